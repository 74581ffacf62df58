"""Cameras of recordings by several cameras: files by hand, and the real ones."""

import json

import numpy as np
import pytest
from scipy.io import savemat

from mcnlab.datasets.multiview import (
    read_campus_cameras,
    read_cmc_cameras,
    read_wildtrack_cameras,
)
from mcnlab.errors import DatasetError

READERS = {
    "wildtrack": read_wildtrack_cameras,
    "campus-auditorium": read_campus_cameras,
    "cmc": read_cmc_cameras,
}
# Looks along y: the camera's x, y, z are the world's x, −z, y.
LEVEL = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])


def write_wildtrack(
    folder, *, lens="1000 0 960 0 1100 540 0 0 1", turn="1.5707963267948966 0 0", shift="0 200 0"
):
    for name, text in (
        ("intrinsic_zero/intr", f"<camera_matrix><data>{lens}</data></camera_matrix>"),
        ("extrinsic/extr", f"<rvec>{turn}</rvec><tvec>\n{shift}\n</tvec>"),
    ):
        path = folder / "calibrations" / f"{name}_CVLab1.xml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"<opencv_storage>{text}</opencv_storage>")
    return folder


def write_campus(folder, **changes):
    one = {
        "name": "view-A",
        "K": np.diag([1000, 1100, 1]).astype(np.uint16),
        "R": LEVEL.astype(float),
        "T": [0, 0, 2.0],
        "scale": 1,
        "center": np.array([960, 540], np.uint16),
    }
    savemat(folder / "cam_param.mat", {"cam_param": {**one, **changes}})
    return folder


def write_cmc(folder, matrix=None):
    lens = np.array([[1000, 0, 960], [0, 1100, 540], [0, 0, 1]])
    matrix = 7 * lens @ np.c_[LEVEL, [0, 2, 0]] if matrix is None else matrix
    np.savetxt(folder / "camera-1.txt", matrix)
    return folder


@pytest.mark.parametrize(
    ("write", "read", "name", "size"),
    [
        (write_wildtrack, read_wildtrack_cameras, "CVLab1", (1920, 1080)),
        (write_campus, read_campus_cameras, "view-A", (1920, 1080)),
        (write_cmc, read_cmc_cameras, "camera-1", (1920, 1024)),
    ],
)
def test_a_level_camera_two_metres_up(tmp_path, write, read, name, size):
    (held,) = read(write(tmp_path)).items()
    assert held[0] == name
    camera = held[1]
    assert (camera.frame_width, camera.frame_height) == size
    assert camera.centre == pytest.approx([0, 0, 2], abs=1e-9)
    # 10 m ahead, 1 m to the right and 2 m below the lens: 100 pixels a metre across, 110 down.
    assert camera.project([1, 10, 0]) == pytest.approx([1060, 760])


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_a_missing_calibration_is_named(tmp_path, read):
    with pytest.raises(DatasetError, match=f"{tmp_path}.* is missing"):
        read(tmp_path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"lens": "1 2 3"}, r"intr_CVLab1\.xml is not an intrinsic"),
        ({"lens": "far"}, r"intr_CVLab1\.xml is not an intrinsic"),
        ({"lens": "0 0 0 0 0 0 0 0 0"}, "CVLab1.*intrinsics"),
        ({"turn": "1 2"}, r"extr_CVLab1\.xml is not an extrinsic"),
        ({"shift": "nan 0 0"}, r"extr_CVLab1\.xml is not an extrinsic"),
    ],
)
def test_a_damaged_wildtrack_calibration_is_named(tmp_path, change, words):
    with pytest.raises(DatasetError, match=words):
        read_wildtrack_cameras(write_wildtrack(tmp_path, **change))


def test_a_lonely_wildtrack_lens_lacks_its_pose(tmp_path):
    write_wildtrack(tmp_path)
    (tmp_path / "calibrations" / "extrinsic" / "extr_CVLab1.xml").unlink()
    with pytest.raises(DatasetError, match=r"extr_CVLab1\.xml is missing"):
        read_wildtrack_cameras(tmp_path)


@pytest.mark.parametrize("change", [{"R": np.eye(2)}, {"K": "far"}, {"center": [1.0, 2, 3]}])
def test_a_damaged_campus_calibration_is_named(tmp_path, change):
    with pytest.raises(DatasetError, match=r"cam_param\.mat is not a calibration of CAMPUS"):
        read_campus_cameras(write_campus(tmp_path, **change))
    (tmp_path / "cam_param.mat").write_bytes(b"no such file" * 20)
    with pytest.raises(DatasetError, match=r"cam_param\.mat is not a calibration of CAMPUS"):
        read_campus_cameras(tmp_path)


@pytest.mark.parametrize("matrix", [np.zeros((3, 4)), np.ones((2, 4)), np.ones((3, 3)), [[np.nan]]])
def test_a_damaged_cmc_calibration_is_named(tmp_path, matrix):
    with pytest.raises(DatasetError, match=r"camera-1\.txt"):
        read_cmc_cameras(write_cmc(tmp_path, matrix))


@pytest.mark.parametrize("name", READERS)
def test_every_real_camera_undoes_itself(recordings, name):
    cameras = READERS[name](recordings / name)
    assert len(cameras) == {"wildtrack": 7, "campus-auditorium": 2, "cmc": 4}[name]
    for camera in cameras.values():
        assert 1.4 < camera.centre[2] < 3.5  # metres above the ground
        rows = camera.horizon + np.linspace(60, 600, 5)
        points = np.stack(np.meshgrid(np.linspace(0, 1919, 5), rows), axis=-1).reshape(-1, 2)
        assert camera.project(camera.to_ground(points)) == pytest.approx(points, abs=1e-9)


def test_feet_on_wildtracks_grid_are_the_feet_of_its_boxes(recordings):
    cameras = list(read_wildtrack_cameras(recordings / "wildtrack").values())
    (path, *_) = sorted((recordings / "wildtrack" / "annotations_positions").glob("*.json"))
    off = []
    for person in json.loads(path.read_text()):
        row, column = divmod(person["positionID"], 480)
        place = [-3 + 0.025 * column, -9 + 0.025 * row]  # metres
        for camera, box in zip(cameras, person["views"], strict=True):
            if box["xmin"] == -1:
                continue
            x, y = camera.project(place)
            assert box["xmin"] <= x <= box["xmax"]
            off.append(abs(y - box["ymax"]) / (box["ymax"] - box["ymin"]))
    # The boxes were drawn by these cameras, in whole pixels.
    assert len(off) > 100
    assert max(off) < 0.02


def test_people_of_cmc_are_in_front_of_every_camera(recordings):
    people = np.loadtxt(recordings / "cmc" / "CMC1" / "people.txt")[:, 7:10]
    for camera in read_cmc_cameras(recordings / "cmc").values():
        assert camera.see(people)[1].mean() > 0.9
