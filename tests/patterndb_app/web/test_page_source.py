"""The page's sources and what is built of them, without a browser."""

from __future__ import annotations

import re

import pytest
from build_page import BUNDLE, LIBRARIES, MOST_BYTES, SOURCE, measure_compressed
from build_page_examples import make_ball, make_saddle, subdivide

from viewer import style


def test_colours_mean_the_same_as_in_all_pictures() -> None:
    source = (SOURCE / "theme.ts").read_text()
    valences = {int(n): colour for n, colour in re.findall(r'^  (\d+): "(#\w{6})",', source, re.M)}
    assert valences == style.VALENCE_COLOURS
    tints = source.partition("TINTS")[2].partition("];")[0]
    assert tuple(re.findall(r'"(#\w{6})"', tints)) == style.TINTS


@pytest.mark.skipif(not (BUNDLE / "page.js").is_file(), reason="the page is not built: make page")
def test_the_bundle_is_small_and_brings_its_licences() -> None:
    assert measure_compressed(BUNDLE) <= MOST_BYTES == 350_000
    licences = (BUNDLE / "licenses.txt").read_text()
    for name in LIBRARIES:
        assert f"\n{name}\n" in licences
    assert licences.count("MIT") >= len(LIBRARIES)


def test_nothing_in_the_page_is_from_elsewhere_or_inline() -> None:
    html = (SOURCE / "index.html").read_text()
    assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\sstyle=|\son\w+=", html)
    for address in re.findall(r'(?:src|href)="([^"]+)"', html):
        assert not re.match(r"[a-z]+:|//|/", address), address
    assert "url(" not in (SOURCE / "page.css").read_text()


@pytest.mark.parametrize(
    "made", [make_ball(5), make_saddle(4), subdivide(make_saddle(3)), subdivide(make_ball(3))]
)
def test_examples_are_surfaces_that_face_outwards(made: tuple[list[object], list[object]]) -> None:
    points, faces = made
    halves = [(f[i - 1], f[i]) for f in faces for i in range(len(f))]  # type: ignore[index,arg-type]
    assert len(set(halves)) == len(halves)
    assert {v for half in halves for v in half} == set(range(len(points)))


def test_a_ball_is_closed_and_faces_outwards() -> None:
    points, faces = make_ball(4)
    halves = {(f[i - 1], f[i]) for f in faces for i in range(4)}
    assert all((b, a) in halves for a, b in halves)
    for face in faces:
        a, b, c = (points[v] for v in face[:3])
        u = [q - p for p, q in zip(a, b, strict=True)]
        w = [q - p for p, q in zip(a, c, strict=True)]
        normal = (u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0])
        assert sum(n * p for n, p in zip(normal, a, strict=True)) > 0
