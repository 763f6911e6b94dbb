from . import edgecounts as edgecounts
