"""From names and options to experiments that run: methods, estimators, policies, thresholds, plug-ins, processes."""
