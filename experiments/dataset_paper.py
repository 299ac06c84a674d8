"""What the paper measured on its dataset (Quentin & Goehring 2024), as rates in [0, 1]."""

MASK_TABLE: dict[str, dict[str, float]] = {
    "antenna": {"ap_50_95": 0.947, "ap_50": 0.989, "ar_100": 0.968},
    "handle": {"ap_50_95": 0.873, "ap_50": 0.990, "ar_100": 0.904},
}
METHOD_TABLE: dict[tuple[str, str], dict[str, float]] = {  # (object, method); AUC AR at AP >= 0.99, u_tg at 15 mm
    ("antenna", "ensemble-add"): {"spearman": 0.58, "auc_ar": 0.523, "u_tg": 0.10},
    ("antenna", "maskval"): {"spearman": 0.72, "auc_ar": 0.660, "u_tg": 0.20},
    ("handle", "ensemble-add"): {"spearman": 0.56, "auc_ar": 0.600, "u_tg": 0.08},
    ("handle", "maskval"): {"spearman": 0.70, "auc_ar": 0.810, "u_tg": 0.55},
}
