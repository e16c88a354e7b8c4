name(indigolog).
version('0.1.0').
title('IndiGolog: agent programs over action theories').
requires(prolog >= '9.0.4').
