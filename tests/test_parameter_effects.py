"""Every parameter has a test that shows what it does."""

from stereotrack_core.tracking.parameters import Settings
from tests.body.test_parameter_effects import EFFECTS as OF_BODY
from tests.depth.test_parameter_effects import EFFECTS as OF_DEPTH
from tests.tracking.test_parameter_effects import EFFECTS as OF_TRACKING

ELSEWHERE = """
body/test_cones.py: proportions; depth/test_chain.py: align_rows match_region background_mode;
depth/test_match.py: matcher edge_images match_left_right; depth/test_rectify.py: least_focal;
depth/test_outline.py: background_empty_scene silhouettes; depth/test_volume.py: up_axis;
experiments/baselines/test_baselines.py: estimator; tracking/arm_search/test_costs.py: arms_apart;
tracking/test_colour.py: colour_weight; tracking/test_detecting.py: detector;
tracking/test_presets.py: matching; tracking/test_run.py: fit_shape;
tracking/test_second_look.py: second_look; tracking/test_smoothing.py: longest_bridge;
tracking/test_thesis.py: sampling model_points; tracking/test_trace.py: iterations;
tracking/test_trace_numbers.py: ut_alpha; tracking/test_trackers.py: least_points search_arms
"""  # parameters by the file whose tests show what they do


def test_every_parameter_has_an_effect():
    shown = {row[0] for row in (*OF_BODY, *OF_DEPTH, *OF_TRACKING)}
    named = [word.rstrip(";") for word in ELSEWHERE.split() if not word.endswith(":")]
    assert sorted([*shown, *named]) == sorted(row.name for row in Settings.rows())
