"""Films and their page: what they hold is what the world did, and a notebook shows it."""

from __future__ import annotations

import json
import re
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atoll

import browser
from conftest import DT

with_page = pytest.mark.skipif(not atoll.has_page(), reason="the package was built without the page")


def content(film: atoll.Film) -> Any:
    """What the page plays."""
    found = re.search(r'<script type="application/json" id="film">(.*?)</script>', film.page(), re.S)
    assert found is not None
    return json.loads(found[1])


def seen(film: atoll.Film) -> Any:
    """The same without how long steps took."""
    film_data = content(film)
    del film_data["frames"]["ms"], film_data["frames"]["phase_ms"], film_data["name"]
    return film_data


def shown(film: atoll.Film) -> str:
    """By a notebook. Stubs leave out what begins with an underscore."""
    return str(getattr(film, "_repr_html_")())


def falling() -> atoll.World:
    return atoll.load_scene("pile:bodies=8").build()


@with_page
def test_a_film_has_the_frames_of_its_block(world: atoll.World) -> None:
    world.steps(3, DT)
    with world.film(every=2, name="crate & <co>", show="colour=force") as film:
        assert film.rolling and film.frames == 1
        world.steps(4, DT)
        world.step(DT / 2, lambda forces: None)
        world.step(DT)
    assert not film.rolling and film.frames == 4 and film.bodies == 2
    world.steps(5, DT)
    film_data = content(film)
    assert film_data["frames"]["step"] == [0, 2, 4, 6]
    assert np.allclose(film_data["frames"]["time"], [0, 2 * DT, 4 * DT, 5.5 * DT])
    assert film_data["name"] == "crate & <co>" and film_data["place"] == "colour=force"
    assert [body["name"] for body in film_data["bodies"]] == ["ground", "crate"]
    assert repr(film) == "<Film of 4 frames, 2 bodies>"


def test_a_film_changes_no_bit() -> None:
    filmed, other = falling(), falling()
    with filmed.film(), filmed.film(every=3):
        filmed.steps(90, DT)
    other.steps(90, DT)
    assert filmed.state_hash() == other.state_hash()


@with_page
def test_showing_a_film_ends_it(world: atoll.World) -> None:
    film = world.film()
    world.steps(2, DT)
    assert repr(film) == "<Film of 3 frames, 2 bodies, rolling>"
    page = film.page()
    world.steps(2, DT)
    assert not film.rolling and film.frames == 3 and film.page() is not None and film.page() == page


def test_a_film_that_is_dropped_and_one_whose_world_is_gone(world: atoll.World) -> None:
    world.film()
    world.steps(2, DT)
    kept = falling().film()
    assert kept.rolling and kept.frames == 1
    kept.end()


def test_a_world_of_a_batch_is_filmed() -> None:
    batch = atoll.Batch("pile:bodies=5", 4, threads=2)
    with batch[2].film() as film:
        batch.step(count=6)
        batch.step(worlds=[0, 1])
    assert film.frames == 7


def test_a_film_is_asked_while_another_thread_steps() -> None:
    world = falling()
    film = world.film()
    thread = threading.Thread(target=world.steps, args=(300, DT))
    thread.start()
    counts = [film.frames for _ in range(200)]
    thread.join()
    assert counts == sorted(counts) and film.frames == 301


@with_page
def test_a_view_is_of_the_world_as_it_stands(world: atoll.World) -> None:
    view = world.view(name="now")
    assert view.frames == 1 and not view.rolling
    before = content(view)
    world.steps(10, DT)
    assert content(view) == before and before["frames"]["step"] == [0]


@with_page
def test_a_recording_is_filmed_as_the_run_was(tmp_path: Path) -> None:
    path = str(tmp_path / "run.rec")
    world = falling()
    with world.record(path), world.film(every=10) as film:
        for _ in range(10):
            world.apply_impulse(world.bodies[-1], [0, 0, 20], [0, 0, 1])
            world.steps(10, DT)
    assert seen(atoll.view(path, every=10)) == seen(film)
    part = content(atoll.view(path, every=4, first=20, last=41, show="play"))
    assert part["frames"]["step"] == [20, 24, 28, 32, 36, 40]
    assert part["name"] == "run.rec" and part["place"] == "play"


@with_page
def test_a_scene_is_run_and_filmed() -> None:
    scene = atoll.load_scene("pile:bodies=8")
    scene.steps = 40
    filmed = atoll.view(scene, every=8, threads=2)
    world = scene.build()
    with world.film(every=8) as film:
        world.steps(40, scene.dt)
    assert seen(filmed) == seen(film)
    assert content(filmed)["name"] == scene.name
    assert atoll.view("pendulum").frames == atoll.load_scene("pendulum").steps + 1


def test_bad_input_is_told(tmp_path: Path, world: atoll.World) -> None:
    path = str(tmp_path / "run.rec")
    with world.record(path):
        world.steps(5, DT)
    cases: list[tuple[Callable[[], object], str]] = [
        (lambda: world.film(every=0), r"World.film: every is 0; expected 1"),
        (lambda: atoll.view(path, every=-1), r"view: every is -1"),
        (lambda: atoll.view(path, last=6), r"view: last is 6; expected 0 to 5"),
        (lambda: atoll.view(path, first=4, last=3), r"view: first is 4; expected 0 to 3"),
        (lambda: atoll.view("pile", first=1), r"view: found first or last of a scene; expected them of a recording"),
        (lambda: atoll.view("pyle"), r"pyle"),
        (lambda: world.view().html(height=0), r"Film.html: height is 0"),
    ]
    for call, words in cases:
        with pytest.raises(atoll.Error, match=words):
            call()
    with pytest.raises(TypeError):
        atoll.view(3)  # type: ignore[arg-type]


@with_page
def test_save_and_open_write_the_page(tmp_path: Path, world: atoll.World, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    film = world.view()
    film.save(str(tmp_path / "page.html"))
    assert (tmp_path / "page.html").read_text() == film.page()
    path = Path(film.open())
    assert path.read_text() == film.page() and opened == [path.as_uri()]
    with pytest.raises(atoll.Error, match="Film.save: can't write /nowhere/page.html"):
        film.save("/nowhere/page.html")


@pytest.mark.skipif(atoll.has_page(), reason="the package was built with the page")
def test_without_the_page_films_say_so(tmp_path: Path, world: atoll.World) -> None:
    film = world.view()
    calls: list[Callable[[], object]] = [film.page, film.html, film.open, lambda: film.save(str(tmp_path / "page.html"))]
    for call in calls:
        with pytest.raises(atoll.Error, match="no page that plays runs: npm was not found when it was built"):
            call()
    assert "no page that plays runs" in shown(film)


@with_page
def test_a_notebook_has_room_for_it(world: atoll.World) -> None:
    """A page is three.js and little more; what would swell a notebook is told of instead."""
    assert len(shown(world.view())) < 400_000
    crowd = atoll.World()
    for _ in range(4000):
        crowd.add_body(shape=atoll.Sphere(0.1), filter=atoll.CollisionFilter(mask=0))
    random = np.random.default_rng(1)
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (4000, 1))
    with crowd.film(name="crowd") as film:
        for _ in range(300):
            crowd.set_poses(random.uniform(-1000, 1000, (4000, 3)), turns)
            crowd.step(DT)
    element = shown(film)
    assert "<iframe" not in element and len(element) < 1000
    assert re.search(r"A film of 301 frames and 4000 bodies, which takes [0-9.]+ MB: more than the 16 MB", element)
    assert len(film.html()) > 16 << 20


@with_page
@pytest.mark.skipif(browser.PROGRAM is None, reason="no Chromium, or no long tests: the page is not looked at")
def test_a_notebook_plays_it(tmp_path: Path, world: atoll.World) -> None:
    with world.film(show="step=7") as film:
        world.steps(9, DT)
    element = shown(film)
    assert element.startswith('<iframe sandbox="allow-scripts"') and 'height="620"' in element
    assert 'height="300"' in film.html(height=300)
    # Loads the page in a frame without the sandbox, which would hide it from the test. The frame loads at any time.
    look = """<script>setInterval(() => {
      const body = document.querySelector('iframe').contentDocument.body;
      if (body && body.dataset.ready) document.body.dataset.shown = body.dataset.step + ' of ' + body.querySelector('#title').textContent;
    }, 100)</script>"""
    page = tmp_path / "notebook.html"
    page.write_text("<!DOCTYPE html><body>" + element.replace(' sandbox="allow-scripts"', "") + look)
    document, console = browser.load(page, tmp_path / "profile")
    assert 'data-shown="7 of world"' in document
    assert console == ""
