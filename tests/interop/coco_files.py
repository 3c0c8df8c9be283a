"""COCO files of one annotation."""

import json


def coco_file(path, names, keypoints, image=None, **annotation):
    """Write points of these names on an image; return the path."""
    content = {
        "images": [{"id": 1, "file_name": "S/3.png"} | (image or {})],
        "annotations": [{"image_id": 1, "category_id": 1, "keypoints": keypoints} | annotation],
        "categories": [{"id": 1, "keypoints": names}],
    }
    path.write_text(json.dumps(content))
    return path
