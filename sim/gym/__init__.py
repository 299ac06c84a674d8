"""The cell as Gymnasium environments: one of decisions, one of motions."""
