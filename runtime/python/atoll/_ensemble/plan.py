"""What an ensemble runs: a plan, as JSON or a dict, and the jobs that it makes.

A plan has one study, or a list of them as "studies", for which what stands beside the list is the default:

    {"studies": [{"scene": "pile:bodies=200", "steps": 240,
                  "parameters": {"material.friction": {"uniform": [0.2, 0.8]}, "mass": [0.5, 1, 2]},
                  "sample": {"count": 100, "seed": 1, "method": "latin-hypercube"}, "seeds": 2}],
     "keep": {"errors": true, "observables": ["max_height"], "series": 10, "state": false, "recording": false}}

Jobs are all combinations of the values that are listed, times the samples, times the seeds.
"""

from __future__ import annotations

import hashlib
import importlib
import itertools
import json
import math
import os
import statistics
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .observables import OBSERVABLES

Value = Union[str, bool, int, float, list[float], dict[str, Any]]

#: Of the format of a job's inputs: another one makes other keys.
_FORMAT = 2
_STUDY_FIELDS = ("scene", "steps", "dt", "seeds", "parameters", "sample", "setup", "observe")
_PLAN_FIELDS = ("studies", "keep", *_STUDY_FIELDS)
_MATERIAL = ("friction", "restitution", "rolling_friction", "torsional_friction")
_MOST_JOBS = 100_000_000


class PlanError(_core.Error):
    """A plan that can't be run: where, what was found and what was expected."""


@dataclass(frozen=True)
class Keep:
    """What is kept of a job besides its state's hash."""

    errors: bool = True
    observables: tuple[str, ...] = ()
    series: int = 0  #: steps after which observables are told each time, from the start on; 0: only of the end
    state: bool = False  #: the snapshot of its end, as states/KEY.snapshot
    recording: bool = False  #: as recordings/KEY/STEP.recording, a file for each part that was run at a time


@dataclass(frozen=True)
class Source:
    """Where a job's scene is from: `text` of a file, which names no other files, or a built-in scene's name."""

    name: str
    text: str | None = None


@dataclass(frozen=True)
class Job:
    """All that determines what comes out, with the version of Atoll."""

    source: Source
    steps: int  #: 0: as many as the scene says
    seed: int
    parameters: dict[str, Value] = field(hash=False)
    keep: Keep
    setup: str = ""  #: "module:function", called with the scene and the parameters
    observe: str = ""  #: "module:function", called with the world and the scene when observables are told; gives numbers by name
    code: str = ""  #: a hash of the files of these modules

    @property
    def key(self) -> str:
        """16 bytes of the SHA-256 of its inputs, in hexadecimal."""
        inputs = {"format": _FORMAT, "library": _core.version, **asdict(self)}
        text = json.dumps(inputs, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Plan:
    studies: tuple[Study, ...]
    keep: Keep

    def __len__(self) -> int:
        return sum(len(study) for study in self.studies)

    def jobs(self) -> Iterator[Job]:
        """In the order of the table."""
        return itertools.chain.from_iterable(study.jobs(self.keep) for study in self.studies)

    def parameters(self) -> list[str]:
        """Names of all that any study sets, in the order in which they come."""
        return list(dict.fromkeys(name for study in self.studies for name in (*study.lists, *study.sampled)))


@dataclass(frozen=True)
class Study:
    source: Source
    steps: int
    seeds: tuple[int, ...]
    lists: dict[str, list[Value]]  #: by parameter: all combinations are run
    sampled: dict[str, list[Value]]  #: by parameter: as many each; the first of all go together
    setup: str
    observe: str
    code: str

    def __len__(self) -> int:
        combinations = math.prod(len(values) for values in self.lists.values())
        return combinations * self._samples() * len(self.seeds)

    def jobs(self, keep: Keep) -> Iterator[Job]:
        for values in itertools.product(*self.lists.values()):
            for sample in range(self._samples()):
                parameters = dict(zip(self.lists, values, strict=True))
                parameters |= {name: drawn[sample] for name, drawn in self.sampled.items()}
                for seed in self.seeds:
                    yield Job(self.source, self.steps, seed, parameters, keep, self.setup, self.observe, self.code)

    def _samples(self) -> int:
        return len(next(iter(self.sampled.values()))) if self.sampled else 1


def read_plan(plan: str | Path | Mapping[str, Any]) -> Plan:
    """Of a JSON file, or of what one would hold. Raises PlanError, and SceneError where a scene is unusable."""
    if isinstance(plan, Mapping):
        return _plan(dict(plan), "plan", Path())
    path = Path(plan)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PlanError(f"{path}: can't be read: {error.strerror if isinstance(error, OSError) else error}") from None
    try:
        document = json.loads(text, object_pairs_hook=_without_twins)
    except json.JSONDecodeError as error:
        raise PlanError(f"{path}:{error.lineno}:{error.colno}: {error.msg}; expected JSON") from None
    except (ValueError, RecursionError) as error:  # of numbers and depths that Python doesn't take
        raise PlanError(f"{path}: {error}; expected JSON") from None
    except _Twin as twin:
        raise PlanError(f'{path}: found "{twin}" twice in an object; expected it once') from None
    if not isinstance(document, dict):
        raise PlanError(f"{path}: found {_found(document)}; expected an object")
    return _plan(document, str(path), path.parent)


def _plan(document: dict[str, Any], at: str, folder: Path) -> Plan:
    _check_fields(document, _PLAN_FIELDS, at)
    keep = _keep(document.get("keep", {}), f"{at}: keep")
    common = {name: value for name, value in document.items() if name in _STUDY_FIELDS}
    listed = document.get("studies", [{}])
    if not isinstance(listed, list) or not listed:
        raise PlanError(f"{at}: studies: found {_found(listed)}; expected a list of objects")
    studies = []
    for number, study in enumerate(listed):
        here = f"{at}: studies[{number}]" if "studies" in document else at
        if not isinstance(study, dict):
            raise PlanError(f"{here}: found {_found(study)}; expected an object")
        _check_fields(study, _STUDY_FIELDS, here)
        merged = {**common, **study}
        merged["parameters"] = {**_object(common, "parameters", at), **_object(study, "parameters", here)}
        studies.append(_study(merged, here, folder))
    if keep.series and not keep.observables and not all(study.observe for study in studies):
        raise PlanError(f'{at}: keep: series: found nothing to tell; expected "observables", or "observe" in all studies')
    plan = Plan(tuple(studies), keep)
    if len(plan) > _MOST_JOBS:
        raise PlanError(f"{at}: found {len(plan)} jobs; expected at most {_MOST_JOBS}")
    return plan


def _study(document: dict[str, Any], at: str, folder: Path) -> Study:
    source = _source(document.get("scene"), f"{at}: scene", folder)
    seeds = _seeds(document.get("seeds", 1), f"{at}: seeds")
    lists: dict[str, list[Value]] = {}
    drawn: dict[str, Callable[[float], Value]] = {}
    parameters = dict(document["parameters"])
    if "dt" in document:
        parameters.setdefault("dt", document["dt"])
    for name, given in parameters.items():
        here = f"{at}: parameters: {name}"
        _check_name(name, here)
        if isinstance(given, dict) and set(given) & set(_DRAWN):
            drawn[name] = _distribution(given, here)
        elif isinstance(given, dict) and "from" in given:
            lists[name] = _spread(given, here)
        elif isinstance(given, list) and (name != "gravity" or _is_nested(given)):
            if not given:
                raise PlanError(f"{here}: found an empty list; expected values")
            lists[name] = given
        else:
            lists[name] = [given]
        for value in lists.get(name, []):
            _check_value(name, value, here)
    sampled: dict[str, list[Value]] = {}
    if drawn or "sample" in document:
        unit = _unit_samples(document.get("sample"), len(drawn), f"{at}: sample")
        sampled = {name: [draw(u) for u in unit[:, i].tolist()] for i, (name, draw) in enumerate(drawn.items())}
        for name, values in sampled.items():
            for value in values:
                _check_value(name, value, f"{at}: parameters: {name}")
    steps = document.get("steps", 0)
    if type(steps) is not int or not (0 < steps <= 1_000_000_000 or "steps" not in document):
        raise PlanError(f"{at}: steps: found {_found(steps)}; expected an integer from 1 to 1000000000")
    inner = next((name for name in parameters if name.startswith("scene.")), None)
    if inner and source.text is not None:
        raise PlanError(f"{at}: parameters: found {inner} for a file; expected a built-in scene")
    setup, observe = document.get("setup", ""), document.get("observe", "")
    code = _code_hash([(setup, f"{at}: setup"), (observe, f"{at}: observe")])
    if not setup:
        foreign = next((name for name in parameters if name.startswith("user.")), None)
        if foreign:
            raise PlanError(f'{at}: parameters: found {foreign}; expected it beside a "setup", which is handed it')
    return Study(source, steps, seeds, lists, sampled, setup, observe, code)


def _source(given: object, at: str, folder: Path) -> Source:
    if not isinstance(given, str) or not given:
        raise PlanError(f'{at}: found {_found(given)}; expected a scene\'s name, as "pile:bodies=100", or file')
    path = folder / given
    if not (given.endswith(".json") or os.path.isfile(path)):
        _core.load_scene(given)  # says what is wrong with it
        return Source(given)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PlanError(f"{at}: {path} can't be read: {error}") from None
    scene = _core.parse_scene(text, str(path))
    # Workers may have no such mesh, or another one: what is in it has to go to them, and into the key.
    return Source(given, scene.text() if _names_files(json.loads(text)) else text)


def _names_files(value: Any) -> bool:
    if isinstance(value, dict):
        return "file" in value or any(map(_names_files, value.values()))
    return isinstance(value, list) and any(map(_names_files, value))


def _seeds(given: object, at: str) -> tuple[int, ...]:
    if type(given) is int and 1 <= given <= _MOST_JOBS:
        return tuple(range(1, given + 1))
    if isinstance(given, list) and given and all(type(seed) is int and 0 <= seed < 2**64 for seed in given):
        if len(set(given)) == len(given):
            return tuple(given)
    raise PlanError(f"{at}: found {_found(given)}; expected how many, or a list of different integers of 64 bits")


def _check_name(name: str, at: str) -> None:
    whole = ("dt", "mass", "gravity")
    if name in whole or name.startswith(("scene.", "settings.", "user.")) and not name.endswith("."):
        return
    if name.startswith("material.") and name.removeprefix("material.") in _MATERIAL:
        return
    names = ", ".join([*whole, *(f"material.{field}" for field in _MATERIAL)])
    raise PlanError(f"{at}: no such parameter; expected {names}, scene.NAME, settings.NAME or user.NAME")


def _check_value(name: str, value: object, at: str) -> None:
    if name.startswith(("scene.", "settings.", "user.")):
        fits = isinstance(value, (str, bool, int, float)) or name.startswith(("settings.", "user."))
        expected = "a number or text"
    elif name == "gravity":
        fits = isinstance(value, list) and len(value) == 3 and all(_is_number(number) for number in value)
        expected = "three numbers, m/s^2"
    else:
        lowest = 0.0 if name.startswith("material.") else math.ulp(0.0)
        fits = _is_number(value) and value >= lowest  # type: ignore[operator]
        expected = "a number, 0 or more" if name.startswith("material.") else "a number above 0"
    if not fits:
        raise PlanError(f"{at}: found {_found(value)}; expected {expected}")


def _spread(given: dict[str, Any], at: str) -> list[Value]:
    _check_fields(given, ("from", "to", "count", "scale"), at)
    low, high = given.get("from"), given.get("to")
    count, scale = given.get("count"), given.get("scale", "linear")
    if not (_is_number(low) and _is_number(high)):
        raise PlanError(f'{at}: found {_found([low, high])}; expected numbers as "from" and "to"')
    assert isinstance(low, (int, float)) and isinstance(high, (int, float))
    if type(count) is not int or not 2 <= count <= _MOST_JOBS:
        raise PlanError(f"{at}: count: found {_found(count)}; expected an integer, 2 or more")
    if scale not in ("linear", "log") or scale == "log" and not 0 < min(low, high):
        raise PlanError(f'{at}: scale: found {_found(scale)}; expected "linear", or "log" between numbers above 0')
    shares = [i / (count - 1) for i in range(count)]
    if scale == "log":
        return [*(float(low * (high / low) ** share) for share in shares[:-1]), float(high)]
    return [float(low + (high - low) * share) for share in shares]


# By name: how many numbers it takes, or None for a list of any length.
_DRAWN: dict[str, int | None] = {"uniform": 2, "log_uniform": 2, "normal": 2, "integers": 2, "choice": None}


def _distribution(given: dict[str, Any], at: str) -> Callable[[float], Value]:
    """From numbers evenly spread over (0, 1)."""
    if len(given) != 1:
        raise PlanError(f"{at}: found {', '.join(given)}; expected one of {', '.join(_DRAWN)}")
    [(kind, numbers)] = given.items()
    if kind == "choice":
        if not isinstance(numbers, list) or not numbers:
            raise PlanError(f"{at}: choice: found {_found(numbers)}; expected a list of values")
        return lambda u: numbers[min(int(u * len(numbers)), len(numbers) - 1)]
    if not isinstance(numbers, list) or len(numbers) != 2 or not all(_is_number(number) for number in numbers):
        raise PlanError(f"{at}: {kind}: found {_found(numbers)}; expected two numbers")
    a, b = numbers
    if kind == "normal":
        if not b > 0:
            raise PlanError(f"{at}: normal: found a deviation of {b}; expected one above 0")
        normal = statistics.NormalDist(a, b)
        return lambda u: normal.inv_cdf(min(max(u, 2.0**-53), 1 - 2.0**-53))
    if not a < b or kind == "log_uniform" and not a > 0:
        above = " above 0" if kind == "log_uniform" else ""
        raise PlanError(f"{at}: {kind}: found {a} and {b}; expected the lower one{above} first")
    if kind == "integers":
        if type(a) is not int or type(b) is not int:
            raise PlanError(f"{at}: integers: found {a} and {b}; expected integers, both of which count")
        return lambda u: min(a + int(u * (b - a + 1)), b)
    if kind == "log_uniform":
        return lambda u: float(a * (b / a) ** u)
    return lambda u: float(a + (b - a) * u)


def _unit_samples(given: object, dimensions: int, at: str) -> NDArray[np.float64]:
    """In [0, 1), shape (samples, dimensions)."""
    if not isinstance(given, dict):
        raise PlanError(f'{at}: found {_found(given)}; expected an object with a "count"')
    _check_fields(given, ("count", "seed", "method"), at)
    count, seed, method = given.get("count"), given.get("seed", 1), given.get("method", "random")
    if type(count) is not int or not 1 <= count <= _MOST_JOBS:
        raise PlanError(f"{at}: count: found {_found(count)}; expected an integer, 1 or more")
    if type(seed) is not int or seed < 0:
        raise PlanError(f"{at}: seed: found {_found(seed)}; expected an integer, 0 or more")
    if dimensions == 0:
        raise PlanError(f"{at}: no parameter is drawn; expected one of {', '.join(_DRAWN)} in one at least")
    generator = np.random.Generator(np.random.PCG64(seed))
    if method == "random":
        return generator.random((count, dimensions))
    if method == "latin-hypercube":
        try:
            qmc: Any = importlib.import_module("scipy.stats.qmc")
        except ImportError:
            raise PlanError(f'{at}: method: latin-hypercube takes SciPy: pip install "atoll[ensemble]"') from None
        points: NDArray[np.float64] = qmc.LatinHypercube(dimensions, rng=generator).random(count)
        return points
    raise PlanError(f'{at}: method: found {_found(method)}; expected "random" or "latin-hypercube"')


def _keep(given: object, at: str) -> Keep:
    if not isinstance(given, dict):
        raise PlanError(f"{at}: found {_found(given)}; expected an object")
    _check_fields(given, ("errors", "observables", "series", "state", "recording"), at)
    for name in ("errors", "state", "recording"):
        if type(given.get(name, False)) is not bool:
            raise PlanError(f"{at}: {name}: found {_found(given[name])}; expected true or false")
    observables = given.get("observables", [])
    if not isinstance(observables, list):
        raise PlanError(f"{at}: observables: found {_found(observables)}; expected a list of names")
    unknown = next((name for name in observables if name not in OBSERVABLES), None)
    if unknown is not None:
        raise PlanError(f"{at}: observables: found {_found(unknown)}; expected some of {', '.join(OBSERVABLES)}")
    series = given.get("series", 0)
    if type(series) is not int or series < 0:
        raise PlanError(f"{at}: series: found {_found(series)}; expected a number of steps, or 0 for none")
    return Keep(
        given.get("errors", True), tuple(observables), series, given.get("state", False), given.get("recording", False)
    )


def function_of(address: str) -> Callable[..., Any]:
    """Of "module:function"."""
    module, _, name = address.partition(":")
    function: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return function


def _code_hash(addresses: Sequence[tuple[object, str]]) -> str:
    digest = hashlib.sha256()
    for address, at in addresses:
        if address == "":
            continue
        if not isinstance(address, str) or address.count(":") != 1:
            raise PlanError(f'{at}: found {_found(address)}; expected "module:function"')
        module = address.partition(":")[0]
        try:
            function_of(address)
            file = importlib.import_module(module).__file__
            assert file is not None
            digest.update(Path(file).read_bytes())
        except Exception as error:
            raise PlanError(f"{at}: {address} can't be imported: {error}") from None
    return digest.hexdigest()[:32] if any(address for address, _ in addresses) else ""


def _check_fields(document: dict[str, Any], fields: Sequence[str], at: str) -> None:
    unknown = next((name for name in document if name not in fields), None)
    if unknown is not None:
        raise PlanError(f'{at}: found "{unknown}"; expected {", ".join(fields)}')


def _object(document: dict[str, Any], name: str, at: str) -> dict[str, Any]:
    given = document.get(name, {})
    if not isinstance(given, dict):
        raise PlanError(f"{at}: {name}: found {_found(given)}; expected an object")
    return given


class _Twin(Exception):
    pass


def _without_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members: dict[str, Any] = {}
    for name, value in pairs:
        if name in members:
            raise _Twin(name)
        members[name] = value
    return members


def _is_number(value: object) -> bool:
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        return False
    return abs(value) <= sys.float_info.max  # which an integer may be above


def _is_nested(values: list[Any]) -> bool:
    return any(isinstance(value, list) for value in values)


def _found(value: object) -> str:
    if value is None:
        return "nothing"
    text = json.dumps(value, default=str)
    return text if len(text) < 60 else text[:57] + "..."
