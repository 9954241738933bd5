# SPDX-License-Identifier: MIT
"""A campaign file: what is run, how often, what varies, and what is accepted."""

import tomllib
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

from whole_file import read_whole

from . import distributions
from .axes import Axis
from .distributions import DistributionError, is_number, shown, text_of
from .zoo import VARIANTS, Zoo

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "host_sim" / "campaigns"
RUNS_MAX = 10_000_000
TOML_BYTES_MAX = 1 << 20
SEED_MAX = 2**63 - 1  # TOML's largest whole number
ZOO_SEED_MAX = 2**32 - 1


class CampaignError(Exception):
    """One line for the user: what, where, what was found, what is allowed."""


@dataclass(frozen=True)
class Accept:
    """What the campaign as a whole has to reach; None is no demand."""

    locked_pct: float | None = None     # at least
    uncontrolled: int | None = None     # runs, at most
    unnamed_pct: float | None = None    # neither locked nor refused, without a named fault, at most
    false_faults: int | None = None     # runs with a fault that names a broken part, at most
    refused_formats: int | None = None  # motors that only a number format refuses, at most


@dataclass(frozen=True)
class Varied:
    """One scenario, with other values of its keys in each run."""

    scenario: str  # as motorsim takes it
    sets: tuple    # imperfection sets, likewise
    vary: dict     # distributions by key

    def values(self, seed, run):
        return distributions.values(self.vary, seed, run)

    def corners(self):
        count = max((distribution.corners for distribution in self.vary.values()), default=0)
        return [{key: distribution.corner(number) for key, distribution in self.vary.items()}
                for number in range(count)]

    def words(self, values):
        words = [self.scenario]
        for name in self.sets:
            words += ["--with", name]
        return words, values

    def settings(self):
        named = {"scenario": self.scenario, "with": ", ".join(self.sets)}
        return named | {f"vary.{key}": str(found) for key, found in self.vary.items()}

    def axes(self, _):
        return {key: Axis(found, lambda row, key=key: row["values"][key])
                for key, found in self.vary.items()}

    def refusal(self, _):
        return None


@dataclass(frozen=True)
class Campaign:
    name: str
    path: Path
    title: str
    drawn: Varied | Zoo  # what is run, and what differs from run to run
    runs: int
    seed: int
    fixed: dict          # texts by key, the same in all runs
    accept: Accept

    def values(self, run):
        """What varies, as texts by key; a function of the seed and the run's number alone."""
        return self.drawn.values(self.seed, run)

    def corners(self):
        """Values of trial runs that reach both ends of every range, and every choice."""
        return self.drawn.corners()

    def arguments(self, values):
        """The arguments of motorsim for a run with these values."""
        words, overrides = self.drawn.words(values)
        words = ["run", *words]
        for key, text in {**self.fixed, **overrides}.items():
            words += ["--set", f"{key}={text}"]
        return words

    def settings(self):
        """All that decides the result of a run of a given number, as texts by name."""
        named = {f"set.{key}": text for key, text in self.fixed.items()}
        return self.drawn.settings() | {"seed": str(self.seed)} | named

    def axes(self, rows):
        """What the runs can be sorted by, by name."""
        return self.drawn.axes(rows)


def names():
    """The campaigns that come with the project."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def find(reference):
    """The file of a name or path."""
    if "/" in reference or reference.endswith(".toml"):
        return Path(reference)
    if reference not in names():
        raise CampaignError(f"no campaign '{reference}'; allowed: {', '.join(names())}, "
                            "or the path of a .toml file")
    return FOLDER / f"{reference}.toml"


def load(reference):
    path = find(reference)
    try:
        document = tomllib.loads(read_whole(path, TOML_BYTES_MAX).decode())
    except OSError as error:
        raise CampaignError(f"{path}: {error.strerror}; expected a campaign file") from error
    except (ValueError, RecursionError) as error:
        raise CampaignError(f"{path}: {error}; expected TOML") from error
    return Reader(path, document).campaign()


def changed(campaign, seed=None, classes=None, settings=()):
    """With another seed, other classes of a zoo or other settings it is another campaign and has another name."""
    if seed is not None:
        most = ZOO_SEED_MAX if isinstance(campaign.drawn, Zoo) else SEED_MAX
        if seed > most:
            raise CampaignError(f"--seed: is {seed}; allowed: a whole number, 0 to {most}")
        campaign = replace(campaign, seed=seed, name=f"{campaign.name}-seed{seed}")
    if classes:
        if not isinstance(campaign.drawn, Zoo):
            raise CampaignError(f"--classes: {campaign.path} is no zoo; allowed: with one")
        campaign = replace(campaign, drawn=replace(campaign.drawn, classes=classes),
                           name=f"{campaign.name}-{'-'.join(classes)}")
    return with_settings(campaign, settings) if settings else campaign


def with_settings(campaign, settings):
    """`settings` are texts KEY=VALUE, as motorsim takes them; of a key that is in the file too these win."""
    fixed = dict(campaign.fixed)
    for text in settings:
        key, equals, value = text.partition("=")
        if not key or not equals:
            raise CampaignError(f"--set: is {text}; allowed: KEY=VALUE")
        if key in campaign.values(0):
            raise CampaignError(f"--set: {key} varies in {campaign.path}; allowed: a key that does not")
        fixed[key] = value
    return replace(campaign, fixed=fixed, name=f"{campaign.name}-set{zlib.crc32(repr(fixed).encode()):08x}")


class Reader:
    """Checks a file's document key by key."""

    KEYS = ("title", "scenario", "with", "zoo", "classes", "runs", "seed", "set", "vary", "accept")

    def __init__(self, path, document):
        self.path, self.document = path, document

    def fail(self, key, text):
        raise CampaignError(f"{self.path}: {key}: {text}")

    def campaign(self):
        for key in self.document:
            if key not in self.KEYS:
                self.fail(key, f"unknown key; allowed: {', '.join(self.KEYS)}")
        fixed = {key: text_of(value) for key, value in self.flat("set", self.table("set"))}
        is_zoo = "zoo" in self.document
        return Campaign(
            name=self.path.stem, path=self.path, title=self.text("title"),
            drawn=self.zoo() if is_zoo else self.varied(fixed),
            runs=self.whole("runs", 1, RUNS_MAX),
            seed=self.whole("seed", 0, ZOO_SEED_MAX if is_zoo else SEED_MAX),
            fixed=fixed, accept=self.accept())

    def varied(self, fixed):
        if "classes" in self.document:
            self.fail("classes", "are those of a zoo; allowed: only with zoo")
        vary = self.vary()
        for key in vary:
            if key in fixed:
                self.fail(f"vary.{key}", "is also in [set]; allowed: one of both")
        return Varied(self.placed(self.text("scenario")), self.sets(), vary)

    def zoo(self):
        for key in ("scenario", "with", "vary"):
            if key in self.document:
                self.fail(key, "stands beside zoo, which draws all of it; allowed: one of both")
        variant, classes = self.document["zoo"], self.document.get("classes")
        if variant not in VARIANTS:
            self.wrong("zoo", variant, " or ".join(f'"{name}"' for name in VARIANTS))
        if not isinstance(classes, list) or not classes or not all(isinstance(name, str) for name in classes):
            self.wrong("classes", classes, "a list of classes of the zoo")
        return Zoo(variant, tuple(classes))

    def text(self, key):
        value = self.document.get(key)
        if not isinstance(value, str) or not value:
            self.wrong(key, value, "a string")
        return value

    def wrong(self, key, value, allowed):
        found = "is missing" if value is None else f"is {shown(value)}"
        self.fail(key, f"{found}; allowed: {allowed}")

    def placed(self, reference):
        """A path in the file is relative to it; a name stays."""
        if "/" in reference or reference.endswith(".toml"):
            return str((self.path.parent / reference).resolve())
        return reference

    def sets(self):
        value = self.document.get("with", [])
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            self.wrong("with", value, "a list of imperfection sets")
        return tuple(self.placed(name) for name in value)

    def whole(self, key, low, high):
        value = self.document.get(key)
        if type(value) is not int or not low <= value <= high:
            self.wrong(key, value, f"a whole number, {low} to {high}")
        return value

    def table(self, key):
        value = self.document.get(key, {})
        if not isinstance(value, dict):
            self.wrong(key, value, "a table")
        return value

    def flat(self, name, table):
        """The values of nested tables by dotted keys."""
        for key, value in table.items():
            if isinstance(value, dict):
                yield from ((f"{key}.{inner}", found)
                            for inner, found in self.flat(f"{name}.{key}", value))
            elif isinstance(value, (str, int, float, list)):
                yield key, value
            else:
                self.wrong(f"{name}.{key}", value, "a string, number or list")

    def vary(self):
        """Each leaf is KEY.DISTRIBUTION."""
        found = {}
        for leaf, value in self.flat("vary", self.table("vary")):
            key, _, kind = leaf.rpartition(".")
            if not key or kind not in distributions.READERS:
                self.fail(f"vary.{leaf}", f"'{kind}' is no distribution; allowed: KEY = "
                          f"{{ DISTRIBUTION = … }}, one of {', '.join(distributions.READERS)}")
            if key in found:
                self.fail(f"vary.{key}", "has two distributions; allowed: one")
            try:
                found[key] = distributions.read(kind, value)
            except DistributionError as error:
                self.fail(f"vary.{leaf}", str(error))
        return found

    def accept(self):
        table = self.table("accept")
        share = (lambda x: is_number(x) and 0 <= x <= 100, "a number, 0 to 100 %")
        count = (lambda x: type(x) is int and x >= 0, "a whole number, 0 or more")
        checks = {"locked_pct": share, "uncontrolled": count, "unnamed_pct": share,
                  "false_faults": count, "refused_formats": count}
        for key, value in table.items():
            if key not in checks:
                self.fail(f"accept.{key}", f"unknown key; allowed: {', '.join(checks)}")
            good, allowed = checks[key]
            if not good(value):
                self.wrong(f"accept.{key}", value, allowed)
        return Accept(**table)
