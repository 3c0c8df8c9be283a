import pytest

from app.widgets.style import resource_files


def test_checkout_has_resources_at_the_top():
    assert resource_files.resource_path("themes", "dark.toml").is_file()


def test_wheel_carries_them_inside_the_package(tmp_path, monkeypatch):
    package = tmp_path / "app"
    inside = package / "resources" / "icons"
    inside.mkdir(parents=True)
    (inside / "play.svg").write_text("<svg/>")
    monkeypatch.setattr(resource_files, "_APP", package)
    assert resource_files.resource_path("icons", "play.svg") == inside / "play.svg"


def test_damaged_installation_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(resource_files, "_APP", tmp_path / "app")
    with pytest.raises(FileNotFoundError, match="reinstall stereotrack"):
        resource_files.resource_folder()
