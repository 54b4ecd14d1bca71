__version__: str
from . import dissertation as dissertation
from . import plots as plots
from . import results as results
from . import sweeps as sweeps
from .experiments.budgets import Budget as Budget
from .experiments.experiment import Experiment as Experiment
from .experiments.experiment import verify as verify
from .experiments.figure_requests import FigureRequest as FigureRequest
from .explorer.display import explore as explore
from .files.builder import load_experiment as load_experiment
from .files.case_files import check_arguments as check_arguments
from .files.design_files import design_toml as design_toml
from .files.design_files import save_design as save_design
from .files.schema import json_schema as json_schema
from .sweeps.tuning import tune as tune
