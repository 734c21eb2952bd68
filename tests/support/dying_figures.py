"""A process of the report that dies of one scene, and makes all else.

Other processes import it: a module of tests they can't, where a package that is installed has a
folder `tests`, as DART has.
"""

import os

from ghostball.reports import report


def die_of_one_scene(path, figures, task):
    if task == report.PART + "stop":
        os._exit(7)
    return report._make(path, figures, task)  # nothing is planted in the other process
