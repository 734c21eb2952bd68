from .criteria import (
    Criteria as Criteria,
    CriteriaError as CriteriaError,
    Criterion as Criterion,
    criteria_beside as criteria_beside,
)
from .junit import junit_xml as junit_xml, write_junit as write_junit
from .library import find_scene as find_scene, scene_names as scene_names, select as select
from .metric_table import METRICS as METRICS, Metric as Metric
from .records import CaseRecord as CaseRecord, Check as Check, Motion as Motion
from .store import ResultsError as ResultsError, ResultsFolder as ResultsFolder
from .suite import (
    DEFAULT_ENGINES as DEFAULT_ENGINES,
    Outcome as Outcome,
    criteria_beside_paths as criteria_beside_paths,
    run_suite as run_suite,
)
from .truth import Truth as Truth, TruthError as TruthError, truth_of as truth_of
from .verdict import RestError as RestError, Verdict as Verdict, verdict_of as verdict_of
