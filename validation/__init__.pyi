from .checks.criteria import Criteria as Criteria, criteria_beside as criteria_beside
from .checks.criterion import CriteriaError as CriteriaError, Criterion as Criterion
from .checks.metric import Metric as Metric
from .checks.metrics import METRICS as METRICS
from .checks.verdict import RestError as RestError, Verdict as Verdict, verdict_of as verdict_of
from .results.records import CaseRecord as CaseRecord, Check as Check, Motion as Motion
from .results.store import Results as Results, ResultsError as ResultsError
from .scenes.library import find_scene as find_scene, scene_names as scene_names, select as select
from .suite.plan import criteria_beside_paths as criteria_beside_paths
from .suite.suite import (
    DEFAULT_ENGINES as DEFAULT_ENGINES,
    SuiteResult as SuiteResult,
    run_suite as run_suite,
)
from .truth.scene_truth import Truth as Truth, TruthError as TruthError, truth_of as truth_of
