"""Names, defaults and enumerations of the module, compared with api.json. For habitat_sim.check."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import habitat_sim

from . import _check_scenes as scenes
from ._check_scenes import Job
from ._check_tally import LeftOutError, Tally

FILE = "api.json"

# What the drop-in leaves out on purpose, by its place in the file, and why.
_OWN = "an import of Habitat's own file, which nothing of others reads"
_FILES = "a file of Habitat's package, whose names are in utils.common itself"
LEFT_OUT: dict[str, dict[str, str]] = {
    "modules.simulator": {
        name: _OWN
        for name in (
            "Any", "Dict", "List", "MutableMapping", "MutableMapping_T", "Optional", "OrderedDict",
            "Union", "attr", "cast", "hsim", "ndarray", "np", "overload", "time",
        )
    },
    "modules.errors": {name: _OWN for name in ("magnum", "mn")},
    "utils.common": {name: _FILES for name in ("common", "quaternion_utils")},
}  # fmt: skip


def api_parts(_: Path) -> list[str]:
    """The groups of the file."""
    return ["names", "values"]


def check_api(job: Job, part: str, tally: Tally) -> None:
    """One group: the names that are there, or the values that new objects have."""
    known = scenes.read_json(job.recordings / FILE)
    if not isinstance(known, dict):
        raise ValueError(f"{FILE}: an object is wanted")
    if part == "names":
        _check_names(job, known, tally)
    else:
        _check_values(known, tally)


def _check_names(job: Job, known: dict[str, Any], tally: Tally) -> None:
    for kind, names in known.get("methods", {}).items():
        _names(f"methods.{kind}", names, _owner(kind), tally)
    for module, names in known.get("modules", {}).items():
        _names(f"modules.{module}", names, _owner(module), tally)
    if "utils.common" in known:
        _names("utils.common", known["utils.common"], _owner("utils.common"), tally)
    if known.get("move_functions"):
        with tally.leaving_out("move_functions"):
            _check_motions(job, known["move_functions"], tally)


def _names(place: str, names: Iterable[str], owner: Any, tally: Tally) -> None:
    """Each name is there, or is refused with words, or is left out on purpose."""
    for name in names:
        if name in LEFT_OUT.get(place, {}):
            tally.on_purpose += 1
        else:
            tally.value(f"{FILE}: {place}.{name}", "there", _presence(owner, name))


def _owner(name: str) -> Any:
    """A module, or a class of one, by its name."""
    owner: Any = habitat_sim
    for word in name.split("."):
        found = getattr(owner, word, None)
        if found is None and owner is habitat_sim:
            found = getattr(habitat_sim.agent, word, None)  # Agent is not always in habitat_sim itself
        if found is None:
            return None
        owner = found
    return owner


def _presence(owner: Any, name: str) -> str:
    if owner is None or name not in dir(owner):
        return "missing"
    words = getattr(inspect.getattr_static(owner, name), "_words", None)  # of a name that is refused
    return "there" if words is None or str(words).strip() else "refused without words"


def _check_motions(job: Job, names: list[str], tally: Tally) -> None:
    """Each motion is acted, with a very small amount. What Enfilade lacks says so."""
    registry = getattr(habitat_sim, "registry", None)
    table = getattr(getattr(registry, "registry", registry), "_mapping", {})
    if "move_fn" in table:  # Habitat's own
        for name in names:
            found = "there" if name in table["move_fn"] else "missing"
            tally.value(f"{FILE}: move_functions.{name}", "there", found)
        return
    files = sorted((job.scenes / "mp3d").glob("*/*.glb"))
    if not files:
        raise LeftOutError(f"there is no scene in {job.scenes / 'mp3d'}")
    spec, amount = habitat_sim.agent.ActionSpec, habitat_sim.agent.ActuationSpec
    with scenes.simulator(files[0]) as sim:
        agent = sim.get_agent(0)
        agent.agent_config.action_space = {name: spec(name, amount(1e-3)) for name in names}
        for name in names:
            tally.value(f"{FILE}: move_functions.{name}", "there", _acts(agent, name))


def _acts(agent: Any, name: str) -> str:
    try:
        agent.act(name)
    except NotImplementedError as e:
        return "there" if str(e).strip() else "refused without words"
    except (KeyError, ValueError) as e:
        return f"missing: {e}"
    return "there"


def _check_values(known: dict[str, Any], tally: Tally) -> None:
    for name, wanted in known.items():
        place = f"{FILE}: {name}"
        if name in ("methods", "modules", "move_functions", "utils.common"):
            continue
        if name == "AgentState":
            tally.value(place, wanted, str(habitat_sim.AgentState()))
        elif name == "geo":
            _fields(place, wanted, habitat_sim.geo, tally)
        elif not isinstance(wanted, dict):
            own = "__version__" if name == "version" else name
            tally.value(place, wanted, _plain(getattr(habitat_sim, own, None)))
        elif hasattr(_owner(name), "__members__"):
            _members(place, wanted, _owner(name), tally)
        else:
            kind, _, method = name.partition(".")
            made = _owner(kind)
            made = None if made is None else made()
            if method and made is not None:
                getattr(made, method)()
            _fields(place, wanted, made, tally)


def _members(place: str, wanted: dict[str, int], kind: Any, tally: Tally) -> None:
    """Each member's number. A member that was not recorded is wrong, too."""
    found = {name: int(value) for name, value in kind.__members__.items()}
    for name in {**wanted, **found}:
        tally.value(f"{place}.{name}", wanted.get(name), found.get(name))


def _fields(place: str, wanted: dict[str, Any], made: Any, tally: Tally) -> None:
    for name, value in wanted.items():
        try:
            found = getattr(made, name)
        except NotImplementedError as e:
            found = str(e)
        except AttributeError:
            found = "missing"
        if name == "action_space":
            found = {
                key: [one.name, one.actuation.amount, one.actuation.constraint]
                for key, one in found.items()
            }
            tally.tree(f"{place}.{name}", value, found)
        else:
            tally.value(f"{place}.{name}", value, _plain(found))


def _plain(value: Any) -> Any:
    """A value as it was recorded: what JSON has, else its text."""
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)
