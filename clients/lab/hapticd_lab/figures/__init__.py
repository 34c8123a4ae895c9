"""The figures and tables of the paper, a module for each group. What a module offers: `SPECS`, its figures in order."""
