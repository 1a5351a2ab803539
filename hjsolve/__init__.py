"""hjsolve: decide whether a mechanical system separates, solve it by quadratures, and give numbers with their error.

    System ──separate──▶ Separation ──solve──▶ Solution ──motion──▶ Motion ──report──▶ file

Every stage is a frozen value made by one verb. The names below are imported when they are first used, so that
``import hjsolve`` itself loads neither sympy nor numpy.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from hjsolve._version import __version__ as __version__
from hjsolve.display import renderers as _renderers

if TYPE_CHECKING:
    from hjsolve import catalog as catalog
    from hjsolve import functions as functions
    from hjsolve.arithmetic.estimate import Estimate as Estimate
    from hjsolve.arithmetic.estimate_array import EstimateArray as EstimateArray
    from hjsolve.arithmetic.measured import Measured as Measured
    from hjsolve.catalog import moving_frames as frames  # noqa: F401
    from hjsolve.closed_form.closed_forms import closed_forms as closed_forms
    from hjsolve.closed_form.forms import RegimeForms as RegimeForms
    from hjsolve.closed_form.regime import Regime as Regime
    from hjsolve.coordinates.find import find_coordinates as find_coordinates
    from hjsolve.coordinates.least_action import jacobi_metric as jacobi_metric
    from hjsolve.coordinates.multipliers import ConstraintForces as ConstraintForces
    from hjsolve.coordinates.multipliers import constraint_forces as constraint_forces
    from hjsolve.coordinates.results import SeparableCoordinates as SeparableCoordinates
    from hjsolve.coordinates.results import Web as Web
    from hjsolve.coordinates.small_oscillations import NormalModes as NormalModes
    from hjsolve.coordinates.small_oscillations import normal_modes as normal_modes
    from hjsolve.coordinates.typed_change import change_coordinates as change_coordinates
    from hjsolve.costs import Cost as Cost
    from hjsolve.costs import cost as cost
    from hjsolve.energy_momentum.energy_momentum_map import EnergyMomentumMap as EnergyMomentumMap
    from hjsolve.energy_momentum.energy_momentum_map import energy_momentum_map as energy_momentum_map
    from hjsolve.ensembles import Batch as Batch
    from hjsolve.ensembles import Status as Status
    from hjsolve.ensembles import ensemble as ensemble
    from hjsolve.ensembles.orbit_derivatives import BatchDerivatives as BatchDerivatives
    from hjsolve.ensembles.orbit_derivatives import ensemble_derivatives as ensemble_derivatives
    from hjsolve.errors import CatalogError as CatalogError
    from hjsolve.errors import ClusterError as ClusterError
    from hjsolve.errors import ExpressionError as ExpressionError
    from hjsolve.errors import ForbiddenMotionError as ForbiddenMotionError
    from hjsolve.errors import ForbiddenPlaceError as ForbiddenPlaceError
    from hjsolve.errors import HJSolveError as HJSolveError
    from hjsolve.errors import InternalError as InternalError
    from hjsolve.errors import InvalidInputError as InvalidInputError
    from hjsolve.errors import InvalidSystemError as InvalidSystemError
    from hjsolve.errors import MissingExtraError as MissingExtraError
    from hjsolve.errors import MissingValueError as MissingValueError
    from hjsolve.errors import NonholonomicError as NonholonomicError
    from hjsolve.errors import NotConvergedError as NotConvergedError
    from hjsolve.errors import NotSeparableError as NotSeparableError
    from hjsolve.errors import OutsideMotionError as OutsideMotionError
    from hjsolve.errors import SeveralToriError as SeveralToriError
    from hjsolve.extended.gyroscopic import gyroscopic_modes as gyroscopic_modes
    from hjsolve.extended.impacts import Impact as Impact
    from hjsolve.extended.impacts import impact as impact
    from hjsolve.extended.linear_hamiltonian import from_hamiltonian as from_hamiltonian
    from hjsolve.mechanics.system import Coordinate as Coordinate
    from hjsolve.mechanics.system import Domain as Domain
    from hjsolve.mechanics.system import Parameter as Parameter
    from hjsolve.mechanics.system import System as System
    from hjsolve.mechanics.system import parameter as parameter
    from hjsolve.motion.derivative_values import MotionDerivatives as MotionDerivatives
    from hjsolve.motion.motion import Motion as Motion
    from hjsolve.motion.state import AnyMotion as AnyMotion
    from hjsolve.motion.state import State as State
    from hjsolve.rays.families import Wavefronts as Wavefronts
    from hjsolve.rays.families import wavefronts as wavefronts
    from hjsolve.rays.family_curve import FamilyCurve as FamilyCurve
    from hjsolve.reports import report as report
    from hjsolve.reports.single_figures import figures as figures
    from hjsolve.resonances.kerr_elements import separatrix as separatrix
    from hjsolve.scenes import Scene as Scene
    from hjsolve.scenes.one_sided_contact import Contact as Contact
    from hjsolve.scenes.one_sided_contact import contact as contact
    from hjsolve.semiclassical.level import Level as Level
    from hjsolve.semiclassical.level import Levels as Levels
    from hjsolve.semiclassical.level_search import levels as levels
    from hjsolve.separation import Obstruction as Obstruction
    from hjsolve.separation import Separation as Separation
    from hjsolve.separation import Undecided as Undecided
    from hjsolve.separation import separate as separate
    from hjsolve.solution.quadratures import Solution as Solution
    from hjsolve.solution.quadratures import solve as solve
    from hjsolve.sweeps import SweepResult as SweepResult
    from hjsolve.sweeps import sweep as sweep
    from hjsolve.theorem.action_along_path import PathAction as PathAction
    from hjsolve.theorem.action_along_path import action_integral as action_integral
    from hjsolve.theorem.answers import Flaw as Flaw
    from hjsolve.theorem.answers import Proof as Proof
    from hjsolve.theorem.canonical_maps import CanonicalMap as CanonicalMap
    from hjsolve.theorem.canonical_maps import canonical as canonical
    from hjsolve.theorem.complete_integral import CompleteIntegral as CompleteIntegral
    from hjsolve.theorem.complete_integral import verify as verify
    from hjsolve.theorem.integrals import involution as involution
    from hjsolve.theorem.integrals import is_integral as is_integral
    from hjsolve.theorem.integrals import poisson_bracket as poisson_bracket
    from hjsolve.theorem.loop_integrals import LoopIntegral as LoopIntegral
    from hjsolve.theorem.loop_integrals import loop_integral as loop_integral
    from hjsolve.theorem.own_motion import OwnMotion as OwnMotion

_PUBLIC = {
    "mechanics.system": "Coordinate Domain Parameter System parameter",
    "coordinates.find": "find_coordinates",
    "coordinates.least_action": "jacobi_metric",
    "coordinates.multipliers": "ConstraintForces constraint_forces",
    "coordinates.results": "SeparableCoordinates Web",
    "coordinates.small_oscillations": "NormalModes normal_modes",
    "coordinates.typed_change": "change_coordinates",
    "closed_form.closed_forms": "closed_forms",
    "closed_form.forms": "RegimeForms",
    "closed_form.regime": "Regime",
    "separation": "separate Separation Obstruction Undecided",
    "solution.quadratures": "solve Solution",
    "energy_momentum.energy_momentum_map": "energy_momentum_map EnergyMomentumMap",
    "semiclassical.level": "Level Levels",
    "semiclassical.level_search": "levels",
    "resonances.kerr_elements": "separatrix",
    "rays.families": "wavefronts Wavefronts",
    "rays.family_curve": "FamilyCurve",
    "ensembles": "ensemble Batch Status",
    "ensembles.orbit_derivatives": "ensemble_derivatives BatchDerivatives",
    "motion.derivative_values": "MotionDerivatives",
    "sweeps": "sweep SweepResult",
    "motion.motion": "Motion",
    "motion.state": "AnyMotion State",
    "arithmetic.estimate": "Estimate",
    "arithmetic.estimate_array": "EstimateArray",
    "arithmetic.measured": "Measured",
    "reports": "report",
    "reports.single_figures": "figures",
    "costs": "cost Cost",
    "theorem.answers": "Flaw Proof",
    "theorem.canonical_maps": "canonical CanonicalMap",
    "theorem.complete_integral": "verify CompleteIntegral",
    "theorem.own_motion": "OwnMotion",
    "theorem.action_along_path": "PathAction action_integral",
    "theorem.integrals": "involution is_integral poisson_bracket",
    "theorem.loop_integrals": "LoopIntegral loop_integral",
    "scenes": "Scene",
    "scenes.one_sided_contact": "Contact contact",
    "extended.gyroscopic": "gyroscopic_modes",
    "extended.impacts": "impact Impact",
    "extended.linear_hamiltonian": "from_hamiltonian",
    "errors": "CatalogError ClusterError ExpressionError ForbiddenMotionError ForbiddenPlaceError HJSolveError "
    "InternalError InvalidInputError InvalidSystemError MissingExtraError MissingValueError NonholonomicError "
    "NotConvergedError NotSeparableError OutsideMotionError SeveralToriError ",
}
_HOMES = {name: home for home, names in _PUBLIC.items() for name in names.split()}
_MODULES = {"catalog": "catalog", "functions": "functions", "frames": "catalog.moving_frames"}

__all__ = ["__version__", *sorted(_MODULES), *sorted(_HOMES)]  # noqa: PLE0604


def _room(name: str) -> Any:
    return importlib.import_module(f"hjsolve.{name}")


_renderers.register("plots", lambda: _room("plots"))
_renderers.register("notebook", lambda: _room("reports.notebook"))
_renderers.register("derivatives", lambda: _room("motion.derivatives.derivatives"))


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for (PEP 562)."""
    if name in _MODULES:
        return _room(_MODULES[name])
    if name not in _HOMES:
        raise AttributeError(f"module 'hjsolve' has no attribute {name!r}")
    value = getattr(_room(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted(__all__)
