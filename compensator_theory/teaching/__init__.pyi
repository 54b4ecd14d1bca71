from ._checks import check as check
from ._checks import judge as judge
from ._course import course_exercises as course_exercises
from ._exercises import Exercise as Exercise
from ._exercises import claim_exercise as claim_exercise
from ._exercises import function_exercise as function_exercise
from ._notebooks import student_notebook as student_notebook
