"""The names of `ertel.`, each said once: type checkers and editors read them here, and so does `__init__.py`."""

# what users type: `dir(ertel)` shows it

from ertel import optics as optics
from ertel import plots as plots
from ertel.case.case import Case as Case
from ertel.case.height_map import Measured as Measured
from ertel.case.sections import Output as Output
from ertel.case.sections import Solver as Solver
from ertel.case.sections import Time as Time
from ertel.inputs import materials as materials
from ertel.inputs import oils as oils
from ertel.inputs.case_files import ConfigError as ConfigError
from ertel.inputs.case_files import load_case as load_case
from ertel.inputs.python import Oil as Oil
from ertel.inputs.python import impact as impact
from ertel.inputs.python import quantity as quantity
from ertel.inputs.python import rolling as rolling
from ertel.physics import cams as cams
from ertel.physics import film_formulas
from ertel.physics import gears as gears
from ertel.physics import hertz as hertz
from ertel.physics.surfaces import Feature as Feature
from ertel.physics.surfaces import RingWaviness as RingWaviness
from ertel.physics.surfaces import SelfAffine as SelfAffine
from ertel.physics.surfaces import Spot as Spot
from ertel.physics.surfaces import Waviness as Waviness
from ertel.results import fronts as fronts
from ertel.results.measurements import Measurement as Measurement
from ertel.results.variables import to_si as to_si
from ertel.runs.compile import cache as cache
from ertel.runs.contact_law import contact_law as contact_law
from ertel.runs.drive import simulate as simulate
from ertel.runs.fit import fit as fit
from ertel.runs.response import respond as respond
from ertel.runs.response import respond_in_rolling as respond_in_rolling
from ertel.runs.response import respond_linearly as respond_linearly
from ertel.runs.result import Result as Result
from ertel.runs.store import open_run
from ertel.runs.store import run as run
from ertel.runs.studies import converge as converge
from ertel.runs.studies import sweep as sweep
from ertel.runs.traction import stribeck as stribeck
from ertel.runs.traction import traction as traction

formulas = film_formulas
open = open_run
__version__: str

# for experts: found by name, not shown

from ertel import apps as apps
from ertel import case as case
from ertel import equations as equations
from ertel import inputs as inputs
from ertel import numerics as numerics
from ertel import physics as physics
from ertel import results as results
from ertel import runs as runs
from ertel import solvers as solvers
from ertel.case.status import Status as Status
from ertel.inputs.case_files import parse_case as parse_case
from ertel.inputs.case_files import to_toml as to_toml
from ertel.inputs.python import sampled as sampled
from ertel.physics import amplitude_reduction as amplitude_reduction
from ertel.physics import line_films
from ertel.physics import units as units
from ertel.physics.lubricant import Lubricant as Lubricant
from ertel.physics.motion import Motion as Motion
from ertel.physics.registry import ASPERITY_LAWS, DENSITY_LAWS, FLUIDITY_LAWS, SHAPES, VISCOSITY_LAWS
from ertel.physics.scales import Parameters as Parameters
from ertel.physics.scales import Scales as Scales
from ertel.runs.contact_law import ContactLaw as ContactLaw
from ertel.runs.fit_result import FitResult as FitResult
from ertel.runs.study_result import ConvergenceResult as ConvergenceResult
from ertel.runs.study_result import StudyResult as StudyResult
from ertel.runs.study_result import TractionCurve as TractionCurve

asperity_laws = ASPERITY_LAWS
density_laws = DENSITY_LAWS
fluidity_laws = FLUIDITY_LAWS
line_formulas = line_films
shapes = SHAPES
viscosity_laws = VISCOSITY_LAWS
