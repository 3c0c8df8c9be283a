import pytest

from app.widgets.style import icons


def test_checkout_has_resources_at_the_top():
    assert icons.resource_path("themes", "dark.toml").is_file()


def test_wheel_carries_them_inside_the_package(tmp_path, monkeypatch):
    package = tmp_path / "app"
    inside = package / "resources" / "icons"
    inside.mkdir(parents=True)
    (inside / "play.svg").write_text("<svg/>")
    monkeypatch.setattr(icons, "_APP", package)
    assert icons.resource_path("icons", "play.svg") == inside / "play.svg"


def test_damaged_installation_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(icons, "_APP", tmp_path / "app")
    with pytest.raises(FileNotFoundError, match="reinstall stereotrack"):
        icons.data_folder("resources")
