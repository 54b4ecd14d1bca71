"""What uses the libraries: experiment files, judging, studies, pages, the dissertation, the command."""
