import numpy as np

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.recording.reader import FrameSet, ViewImages
from tests.depth.recordings import MemoryReader, depth_recording

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


def test_what_is_touched_in_the_image_alone_is_the_scene():
    shown = foreground([pictures(rows, trunk=3.2) for rows in range(70, 150, 10)])
    assert not shown[TRUNK].any()


def test_a_person_who_does_not_move_at_all_is_told_by_size():
    for count in (1, 8):
        shown = foreground([pictures(90)] * count)
        assert shown[TRUNK].mean() > 0.95
        assert shown[92:100, 185:220].all()
        assert not shown[:, 230:].any()
        assert not shown[:, :130].any()


def test_of_a_scene_without_motion_what_is_low_or_large_is_learned_as_it_is():
    low, large, wall = pictures(0), pictures(0), pictures(0)
    for images in (low, large, wall):
        images.depth[:] = WALL
    low.depth[180:220, 60:120] = PERSON
    large.depth[20:220, 20:300] = PERSON
    for images in (low, large, wall):
        assert not foreground([images] * 8).any()
