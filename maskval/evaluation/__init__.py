"""What uncertainties are worth on poses whose truth is known: errors, matching, metrics, thresholds, a summary."""
