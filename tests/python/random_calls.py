"""Calls whatever the package has, with arguments of the types that its signatures name and with some that they don't.

    python random_calls.py SEED COUNT

Any exception will do but those that say the interpreter was misused, and nothing may take more than some seconds. Run
by test_random_calls.py, as a process of its own: a crash ends it.
"""

from __future__ import annotations

import faulthandler
import inspect
import random
import resource
import signal
import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import atoll
from atoll import _core

MEMORY = 8 << 30  # bytes of address space: what asks for more gets MemoryError
PATIENCE = 20  # s
POOL = 300
NUMBERS = [0, 1, 2, 3, -1, 2**31, 2**63, 2**64, 10**30, 0.5, 1e-3, -2.5, 1e300, 1e-300, float("nan"), float("inf")]
TEXTS = ["", "a", "x" * 1000, "\n", "static", "a\0b", "\N{BUG}", "\ud800", "positions"]
SHAPES = [(), (0,), (1,), (3,), (4,), (6,), (0, 3), (2, 3), (3, 3), (4, 4), (1, 2, 3), (2, 2, 6)]
TYPES: list[Any] = [np.float64, np.float64, np.float32, np.int64, np.uint32, np.bool_, np.complex128, "O", "U3"]
CLASSES = [each for each in vars(_core).values() if inspect.isclass(each)]
FUNCTIONS = [each for each in vars(_core).values() if callable(each) and not inspect.isclass(each)]


class Late(BaseException):
    """A call that doesn't come back."""


def late(*_: object) -> None:
    raise Late


class Caller:
    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.pool: list[Any] = []
        self.wrong: list[str] = []
        self.returned = 0

    def begin(self) -> None:
        world = atoll.World()
        first = world.add_body(shape=atoll.Box([0.5, 0.5, 0.5]), position=[0, 0, 1])
        second = world.add_body(shape=atoll.Sphere(0.5), position=[0, 0, 3])
        joint = atoll.JointDef(kind=atoll.BallJoint(), first=first, second=second)
        self.pool += [world, first, second, joint, world.add_joint(joint), world.save(), atoll.BodyDef()]

    def array(self) -> Any:
        shape, kind = self.random.choice(SHAPES), self.random.choice(TYPES)
        values = np.array([self.random.uniform(-2, 2) for _ in range(int(np.prod(shape)))]).reshape(shape)
        made = values.astype(kind)
        return self.random.choice([made, made.T, made[::2] if made.ndim else made, np.asfortranarray(made)])

    def anything(self, depth: int = 0) -> Any:
        choices: list[Callable[[], Any]] = [
            lambda: self.random.choice(self.pool),
            lambda: self.random.choice(NUMBERS),
            lambda: self.random.choice(TEXTS),
            lambda: self.random.choice([None, True, False, object(), b"abc", lambda *_: None, lambda *_: 1 / 0]),
            lambda: self.random.choice(CLASSES),
            self.array,
        ]
        if depth < 2:
            choices.append(lambda: [self.anything(depth + 1) for _ in range(self.random.randrange(4))])
        return self.random.choice(choices)()

    def named(self, kind: str) -> Any:
        """A value of a type, as signatures write it."""
        kind = self.random.choice(kind.split(" | ")) if "[" not in kind else kind
        fitting = [each for each in self.pool if type(each).__name__ == kind.rpartition(".")[2]]
        if fitting:
            return self.random.choice(fitting)
        if kind.startswith("float"):
            return self.random.uniform(0, 2)
        if kind.startswith("int"):
            return self.random.randrange(5)
        if kind.startswith("bool"):
            return self.random.random() < 0.5
        if kind.startswith("str"):
            return self.random.choice(TEXTS)
        if "Callable" in kind:
            return self.random.choice([lambda *_: None, lambda *_: True, lambda *_: 1 / 0])
        if "NDArray" in kind or "Sequence[float]" in kind:
            return np.array([self.random.uniform(-1, 1) for _ in range(self.random.choice([3, 3, 3, 4, 6]))])
        return self.anything()

    def arguments(self, function: Any) -> tuple[list[Any], dict[str, Any]]:
        signatures = getattr(function, "__nb_signature__", None)
        if not signatures or self.random.random() < 0.2:
            return [self.anything() for _ in range(self.random.randrange(5))], {}
        text = self.random.choice(signatures)[0]
        places: list[Any] = []
        names: dict[str, Any] = {}
        only_names = False
        for part in parts(text):
            name, _, kind = part.partition(": ")
            kind, _, default = kind.partition(" = ")
            only_names |= name == "*"
            if name.startswith(("*", "self")) or name == "/" or (default and self.random.random() < 0.6):
                only_names |= bool(default)
                continue
            value = self.named(kind) if self.random.random() < 0.9 else self.anything()
            if only_names:
                names[name] = value
            else:
                places.append(value)
        return places, names

    def keep(self, value: Any) -> None:
        if type(value).__module__.startswith("atoll"):
            self.pool.append(value)
        elif isinstance(value, (list, tuple)):
            for each in value[:3]:
                self.keep(each)

    def attempt(self, words: str, call: Callable[[], Any]) -> None:
        signal.alarm(PATIENCE)
        try:
            self.keep(call())
            self.returned += 1
        except (SystemError, RecursionError) as error:
            self.wrong.append(f"{words}: {error!r}")
        except Late:
            self.wrong.append(f"{words}: not back after {PATIENCE} s")
        except Exception:  # whatever it says: test_arguments.py looks at words
            pass
        finally:
            signal.alarm(0)

    def call(self, name: str, function: Any, bound: Callable[[], Any] | None = None) -> None:
        """`bound` gets what is called, if that isn't the function whose signature counts."""
        places, names = self.arguments(function)
        words = f"{name} {places!r:.300} {names!r:.300}"
        print(words.encode("utf-8", "replace"), file=sys.stderr, flush=True)
        self.attempt(words, lambda: (bound() if bound else function)(*places, **names))

    def step(self) -> None:
        choice = self.random.random()
        if choice < 0.25:
            of = self.random.choice(CLASSES)
            self.call(of.__name__, of.__init__ if self.random.random() < 0.1 else of)
        elif choice < 0.3:
            function = self.random.choice(FUNCTIONS)
            self.call(getattr(function, "__name__", "function"), function)
        else:
            of = self.random.choice(self.pool)
            name = self.random.choice([each for each in dir(of) if each not in dir(object)] or ["__repr__"])
            words, found = f"{type(of).__name__}.{name}", getattr(type(of), name, None)
            if self.random.random() < 0.2:
                value = self.anything()
                self.attempt(f"{words} = {value!r:.300}", lambda: setattr(of, name, value))
                return
            self.attempt(words, lambda: getattr(of, name))
            if callable(found):
                self.call(words, found, lambda: getattr(of, name))
        if len(self.pool) > POOL:
            self.pool = self.random.sample(self.pool, POOL // 2)
            self.begin()


def parts(signature: str) -> list[str]:
    """Of `def f(a: list[int, x], *, b: float = 1) -> x`, what stands between its commas."""
    inside = signature[signature.index("(") + 1 :]
    found, depth, begin = [], 0, 0
    for place, letter in enumerate(inside):
        depth += (letter in "([") - (letter in ")]")
        if depth < 0 or (depth == 0 and letter == ","):
            found.append(inside[begin:place].strip())
            begin = place + 1
        if depth < 0:
            break
    return [part for part in found if part]


def main() -> None:
    faulthandler.enable()
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    signal.signal(signal.SIGALRM, late)
    caller = Caller(int(sys.argv[1]))
    caller.begin()
    for _ in range(int(sys.argv[2])):
        caller.step()
    print(f"{caller.returned} calls came back with a result")
    sys.exit("\n".join(caller.wrong) or 0)


if __name__ == "__main__":
    main()
