from types import SimpleNamespace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stereotrack_core.depth.background import averaged, percentile_model
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.recordings import MemoryReader, depth_recording

disparity = st.one_of(st.just(float("nan")), st.floats(0.5, 60.0, width=32))

images = st.lists(arrays(np.float32, (3, 4), elements=disparity), min_size=1, max_size=12)


def oracle_average(sequence, rate, validity_rate):
    """The recursions of 3.1.1, one pixel after the other, in double precision."""
    shape = sequence[0].shape
    d_model, g_model = np.zeros(shape), np.zeros(shape)
    for k, image in enumerate(sequence):
        for v in range(shape[0]):
            for u in range(shape[1]):
                d = float(image[v, u])
                valid = d == d
                if valid and (k == 0 or g_model[v, u] == 0):
                    d_model[v, u] = d
                elif valid:
                    d_model[v, u] = (1 - rate) * d_model[v, u] + rate * d
                if k == 0:
                    g_model[v, u] = float(valid)
                else:
                    g_model[v, u] = (1 - validity_rate) * g_model[v, u] + validity_rate * valid
    return d_model, g_model


@given(images, st.floats(0.01, 1.0), st.floats(0.01, 0.99))
@settings(max_examples=60, deadline=None)
def test_averages_agree_with_the_equations_pixel_by_pixel(sequence, rate, validity_rate):
    model = None
    for image in sequence:
        model = averaged(model, image, rate, validity_rate)
    d_model, g_model = oracle_average(sequence, rate, validity_rate)
    assert np.allclose(model.frequency, g_model, atol=1e-5)
    seen = g_model > 0
    assert np.allclose(model.disparity[seen], d_model[seen], rtol=1e-4)


@given(images, arrays(np.float32, (3, 4), elements=disparity), st.floats(0.0, 5.0))
@settings(max_examples=60, deadline=None)
def test_foreground_agrees_with_equation_3_3(sequence, image, threshold):
    model = percentile_model(sequence, 20.0)
    got = image > model.limit(threshold)
    for v in range(3):
        for u in range(4):
            d, d_model = image[v, u], np.float32(model.disparity[v, u])
            valid, known = d == d, model.frequency[v, u] > 0.5
            expected = valid and (not known or d > d_model + np.float32(threshold))
            assert got[v, u] == expected


def test_a_resting_person_melts_into_the_average_but_not_into_the_percentile():
    wall, person = np.full((2, 2), 5.0, np.float32), np.full((2, 2), 15.0, np.float32)
    sequence = [wall] * 30 + [person] * 60
    model = None
    for image in sequence:
        model = averaged(model, image, 0.05, 0.05)
    assert not (person > model.limit(1.0)).any()
    assert (person > percentile_model(sequence, 20.0).limit(1.0)).all()


HEIGHT, WIDTH = 240, 320
TRUNK = slice(60, 200), slice(140, 180)
WALL, PERSON = 4.0, 2.4


def pictures(arm_rows, *, trunk=PERSON):
    """A trunk before a wall and an arm beside it, at some height."""
    depth = np.full((HEIGHT, WIDTH), WALL, dtype=np.float32)
    depth[TRUNK] = trunk
    depth[arm_rows : arm_rows + 12, 180:225] = PERSON
    image = np.full((HEIGHT, WIDTH), 100, dtype=np.uint8)
    return ViewImages(image=image, depth=depth)


def foreground(frames, **values):
    """Foreground of the last frame after learning from all."""
    recording = depth_recording()
    usual = {"volume_centre_y": 0.4, "volume_x": 4.0, "volume_y": 5.0, "speckle_size": 0}
    chain = DepthChain(recording, DepthParameters().replaced(**usual | values))
    sets = [FrameSet(k, {"K": images}) for k, images in enumerate(frames)]
    chain.learn_background(MemoryReader(recording, sets, empty=False), range(len(sets)))
    found = chain.process(sets[-1]).depths["K"].foreground
    chain.close()
    return found


def moving_arm():
    return [pictures(rows) for rows in range(70, 150, 10)]


def test_a_trunk_that_stands_still_while_an_arm_moves_is_no_background():
    shown = foreground(moving_arm())
    assert shown[TRUNK].mean() > 0.95
    assert shown[142:150, 185:220].all()
    assert not shown[:, 230:].any()
    assert not shown[:, :130].any()


def test_what_is_not_touched_by_what_moves_is_the_scene():
    frames = moving_arm()
    for images in frames:
        images.depth[60:200, 20:60] = PERSON  # furniture of a person's size
    shown = foreground(frames)
    assert shown[TRUNK].mean() > 0.95
    assert not shown[60:200, 20:60].any()


def test_a_person_who_does_not_move_at_all_is_told_by_size():
    for count in (1, 8):
        shown = foreground([pictures(90)] * count)
        assert shown[TRUNK].mean() > 0.95
        assert shown[92:100, 185:220].all()
        assert not shown[:, 230:].any()
        assert not shown[:, :130].any()


def test_the_background_is_learned_from_frames_spread_over_the_recording():
    asked, chain = [], DepthChain(depth_recording(), DepthParameters())
    shown = FrameSet(0, {"K": pictures(90)})
    reader = SimpleNamespace(frame_set=lambda k: asked.append(k) or shown)
    chain.learn_background(reader, range(1000, 1200))
    assert (asked[0], asked[-1], len(asked)) == (1000, 1199, 40)
    assert set(np.diff(asked)) == {5, 6}
