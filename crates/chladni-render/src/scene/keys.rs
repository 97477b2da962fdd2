//! The keys of a scene file.

use chladni_text::toml_reader::Keys;

/// Every key of a scene, by table.
pub(super) const KEYS: Keys = &[
    (
        "",
        &[
            "frequency_hz",
            "threshold",
            "zones",
            "actuators",
            "drift",
            "touch",
            "time",
        ],
    ),
    (
        "drift",
        &[
            "frequency_relative",
            "loss_factor_relative",
            "shape_relative",
            "isotropic_relative",
            "drive_relative",
        ],
    ),
    ("threshold", &["profile", "limen_db"]),
    (
        "zones",
        &[
            "grid",
            "hot",
            "area_m",
            "cells_m",
            "transition_m",
            "polygon",
        ],
    ),
    ("zones.polygon[]", &["kind", "points_m", "level_db"]),
    (
        "actuators",
        &[
            "use",
            "max_force_n",
            "max_voltage_v",
            "max_current_a",
            "max_apparent_power_va",
            "resistance_ohm",
            "inductance_h",
            "capacitance_f",
            "max_effort",
            "dead",
            "calibration",
        ],
    ),
    (
        "touch",
        &[
            "fingers",
            "where",
            "points_m",
            "criterion",
            "impedance",
            "kappa_least",
        ],
    ),
    ("touch.impedance", &["c", "m", "k"]),
    (
        "time",
        &[
            "measure",
            "summation_s",
            "level",
            "ramps",
            "burst",
            "fade",
            "move",
        ],
    ),
    (
        "time.burst[]",
        &["start_s", "duration_s", "ramp_s", "repeat", "hot"],
    ),
    (
        "time.fade[]",
        &["from", "to", "start_s", "fade_s", "ramp_s"],
    ),
    (
        "time.move[]",
        &[
            "start_s",
            "path_m",
            "speed_m_per_s",
            "hot_radius_m",
            "quiet_from_m",
            "ramp_s",
        ],
    ),
];
