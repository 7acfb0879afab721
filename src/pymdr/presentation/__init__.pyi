from . import files as files
from . import html as html
from . import plot as plot
from . import report as report
from . import tables as tables
from . import text as text
