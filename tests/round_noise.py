"""An error model of round numbers, so that tests state what follows from them, whatever the package's are fitted to."""

from sim.networks.noise_model import load_noise

ROUND = load_noise("antenna").changed(
    {
        "pose.lateral_mm": 0.5,
        "pose.rotation_deg": 2.05,
        "pose.difficulty_gain": 0.46,
        "pose.hidden_gain": 1.86,
        "pose.outlier_probability": 0.018,
        "pose.outlier_difficulty_gain": 0.9,
        "pose.outlier_hidden_gain": 4.1,
        "pose.second_scale": 1.57,
        "pose.second_outlier_odds_ratio": 2.8,
        "pose.second_difficulty_correlation": 0.6,
        "pose.second_core_correlation": 0.33,
        "pose.second_outlier_correlation": 0.45,
        "mask.difficulty_gain": 0.35,
        "mask.field_cells": 0.15,
        "mask.box_share": 0.0135,
        "mask.leak_cells": 0.37,
        "mask.drop_probability": 0.005,
        "mask.miss_probability": 0.0024,
        "mask.score_sd": 0.12,
        "mask.false_alarms_per_image": 0.01,
    }
)
