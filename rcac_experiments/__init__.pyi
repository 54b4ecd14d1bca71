__version__: str
from . import dissertation as dissertation
from . import plots as plots
from . import results as results
from . import sweeps as sweeps
from .experiments._budgets import ExperimentBudget as ExperimentBudget
from .experiments._experiment import Experiment as Experiment
from .experiments._experiment import verify as verify
from .experiments._figure_requests import FigureRequest as FigureRequest
from .explorer._display import explore as explore
from .files._builder import load_experiment as load_experiment
from .files._case_files import check_arguments as check_arguments
from .files._design_files import design_toml as design_toml
from .files._design_files import save_design as save_design
from .files._schema import json_schema as json_schema
from .tuning._tuning import tune as tune
