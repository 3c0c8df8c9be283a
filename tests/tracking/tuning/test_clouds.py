"""Clouds that are kept are those that would be made."""

import numpy as np
import pytest

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.tracking.tuning.clouds import CloudKey
from tests.tracking.tuning.test_stages import other_value

USUAL = DepthParameters()
STRETCH = range(3)
QUICK = ("low_pass",)


def made_anew(recording, reader, depth, frame):
    chain = DepthChain(recording, depth)
    chain.learn_background(reader, STRETCH)
    cloud = chain.process(reader.frame_set(frame))
    chain.close()
    return cloud


def same(a, b):
    for name in ("points", "view", "pixels"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert a.problems == b.problems
    for name, view in a.depths.items():
        other = b.depths[name]
        for field in ("disparity", "range_z", "foreground", "silhouette", "outline"):
            np.testing.assert_array_equal(getattr(view, field), getattr(other, field))


def parameters():
    for row in DepthParameters.rows():
        yield pytest.param(row, marks=() if row.name in QUICK else pytest.mark.slow, id=row.name)


@pytest.mark.parametrize("row", tuple(parameters()))
@pytest.mark.parametrize("empty_scene", [True, False])
def test_after_any_change_kept_clouds_are_those_that_are_made_anew(
    rendered, store_of, row, empty_scene
):
    store = store_of(rendered)
    before = USUAL.replaced(background_empty_scene=empty_scene)
    key = CloudKey(before, STRETCH)
    store.clouds(key, STRETCH).take(1)
    after = before.replaced(**{row.name: other_value(row)})
    if row.name == "background_empty_scene":
        after = before.replaced(background_empty_scene=not empty_scene)
    changed = CloudKey(after, STRETCH)
    same(store.clouds(changed, STRETCH).take(1)[0], made_anew(rendered, store.reader, after, 1))
    same(store.clouds(key, STRETCH).take(1)[0], made_anew(rendered, store.reader, before, 1))


def test_the_same_clouds_are_not_made_twice(cones, store_of, monkeypatch):
    store, key = store_of(cones), CloudKey(DepthParameters(), range(6))
    first = store.clouds(key, range(2, 5)).take(3)[0]
    monkeypatch.delattr(DepthChain, "measured")
    assert store.clouds(key, range(2, 5)).take(3)[0] is first
    other = CloudKey(DepthParameters(outlier_distance=50.0), range(6))
    assert store.clouds(other, range(3, 4)).take(3)[0] is not first


def test_a_background_that_is_still_learned_is_learned_in_order_and_nothing_is_kept(
    rendered, store_of
):
    store = store_of(rendered)
    depth = USUAL.replaced(background_mode="average", background_empty_scene=False)
    key = CloudKey(depth, STRETCH)
    chain = DepthChain(rendered, depth)
    chain.learn_background(store.reader, STRETCH)
    in_order = [chain.process(store.reader.frame_set(k)) for k in STRETCH]
    chain.close()
    for _ in range(2):
        kept = store.clouds(key, STRETCH)
        for k in STRETCH:
            same(kept.take(k)[0], in_order[k])


def test_memory_is_bounded_and_clouds_stay_right(cones, store_of):
    store, key = store_of(cones, limit=2_000_000), CloudKey(DepthParameters(), range(6))
    for _ in range(2):
        kept = store.clouds(key, range(6))
        for k in range(6):
            cloud = kept.take(k)[0]
            assert store.memory.bytes <= 2_000_000
            np.testing.assert_array_equal(
                cloud.points, made_anew(cones, store.reader, key.depth, k).points
            )
    assert 0 < len(store.memory) < 6
