"""What an impact does: one small function for each law, chosen by name in the scene.

`registry` names the laws; `interface` is the one signature that each kind of law has; `dispatch`
calls the law that a scene chose. To add a law, write its file, name it in `registry` and give it
its branch in `dispatch`.
"""
