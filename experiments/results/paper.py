"""What the paper measured on its robot (Quentin & Goehring 2024, table IV): 5 experiments of 8 parts per cell."""

ROBOT_TABLE: dict[tuple[str, str], tuple[float, float]] = {  # (object, method): (AP, AR)
    ("antenna", "none"): (0.900, 0.825),
    ("antenna", "ensemble-add"): (0.960, 0.500),
    ("antenna", "maskval"): (0.975, 1.000),
    ("handle", "none"): (0.614, 0.500),
    ("handle", "ensemble-add"): (1.000, 0.700),
    ("handle", "maskval"): (1.000, 0.725),
}
