"""One session of the controller: its Prolog files, and the command that an installed copy starts it with."""
