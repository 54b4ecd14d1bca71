from matplotlib.figure import Figure as Figure
