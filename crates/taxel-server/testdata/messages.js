// Written by crates/taxel-server/src/tests/wire.rs; see there. Not to be changed by hand.

/** @type {Wire.Hello} */
export const hello = {
  "kind": "hello",
  "protocol": 3,
  "program": "taxel 0",
  "sensor": {
    "name": "a \"mat\" – 2 × 3",
    "rows": 2,
    "columns": 3,
    "pitch_mm": [
      2.0,
      1.5
    ],
    "taxel_area_mm2": 5.0,
    "cell_area_mm2": 3.0,
    "bits": 16,
    "max_count": 65535.0,
    "has_load_law": true,
    "calibration": "calibrated 2026-11-10 (12 days ago); not checked since",
    "exported": null,
    "positions_mm": null,
    "regions": [
      {
        "name": "thumb",
        "boxes": [
          [
            0,
            1,
            1,
            2
          ]
        ],
        "windows": []
      },
      {
        "name": "index",
        "boxes": [
          [
            0,
            1,
            0,
            0
          ]
        ],
        "windows": [
          {
            "frames": [
              0,
              9
            ],
            "boxes": [
              [
                0,
                0,
                0,
                0
              ]
            ]
          },
          {
            "frames": [
              20,
              29
            ],
            "boxes": [
              [
                1,
                1,
                0,
                0
              ]
            ]
          }
        ]
      }
    ],
    "handle": null
  },
  "source": {
    "address": "sim:econe?hand",
    "type": "sim"
  },
  "methods": [
    "exact",
    "raw"
  ],
  "can_record": true,
  "sliders": [
    {
      "key": "r_mux_row_ohms",
      "label": "Row switch",
      "unit": "Ω",
      "value": 10.0,
      "type": "range",
      "min": 0.1,
      "max": 500.0,
      "step": 0.1,
      "logarithmic": true
    },
    {
      "key": "dead_row",
      "label": "Dead row",
      "unit": "",
      "value": 1.0,
      "type": "switch"
    }
  ],
  "file": null,
  "marks": [
    {
      "word": "good",
      "text": "Nothing is known against it.",
      "severity": 0,
      "counts": true,
      "scales": true
    },
    {
      "word": "open",
      "text": "On a line that is dead: the frame says nothing about it.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "saturated",
      "text": "At the converter's ceiling: the value is a lower bound.",
      "severity": 2,
      "counts": true,
      "scales": true
    },
    {
      "word": "stuck",
      "text": "Stuck at an end of the converter.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "spike",
      "text": "A spike against its neighbours or over time.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "flickering",
      "text": "On a line that comes and goes.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "shorted",
      "text": "On lines that read alike because they are shorted together.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "interpolated",
      "text": "Not measured: the median of its neighbours.",
      "severity": 1,
      "counts": true,
      "scales": true
    },
    {
      "word": "unresolved",
      "text": "The cross-talk cannot be undone: its standard error exceeds its value.",
      "severity": 1,
      "counts": false,
      "scales": true
    },
    {
      "word": "unfamiliar",
      "text": "A network's estimate from an input unlike those it was trained with.",
      "severity": 1,
      "counts": false,
      "scales": true
    },
    {
      "word": "absent",
      "text": "There is no taxel at this crossing.",
      "severity": 0,
      "counts": false,
      "scales": false
    },
    {
      "word": "below-floor",
      "text": "Below what the recorder keeps: taken to be unloaded, and may be loaded by as much as reads that little.",
      "severity": 1,
      "counts": true,
      "scales": true
    }
  ]
};

/** @type {Wire.Hello} */
export const helloOfFile = {
  "kind": "hello",
  "protocol": 3,
  "program": "taxel 0",
  "sensor": {
    "name": "",
    "rows": 1,
    "columns": 2,
    "pitch_mm": [
      1.0,
      1.0
    ],
    "taxel_area_mm2": 1.0,
    "cell_area_mm2": 1.0,
    "bits": 0,
    "max_count": 0.0,
    "has_load_law": false,
    "calibration": null,
    "exported": {
      "words": "numbers as another program has exported them",
      "unit": "kPa",
      "per_siemens": 200000000.0
    },
    "positions_mm": [
      [
        1.5,
        -2.0
      ],
      null
    ],
    "regions": [],
    "handle": null
  },
  "source": {
    "address": "file:run.mcap",
    "type": "file"
  },
  "methods": [],
  "can_record": false,
  "sliders": [],
  "file": {
    "frames": 500,
    "duration_secs": 5.0
  },
  "marks": [
    {
      "word": "good",
      "text": "Nothing is known against it.",
      "severity": 0,
      "counts": true,
      "scales": true
    },
    {
      "word": "open",
      "text": "On a line that is dead: the frame says nothing about it.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "saturated",
      "text": "At the converter's ceiling: the value is a lower bound.",
      "severity": 2,
      "counts": true,
      "scales": true
    },
    {
      "word": "stuck",
      "text": "Stuck at an end of the converter.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "spike",
      "text": "A spike against its neighbours or over time.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "flickering",
      "text": "On a line that comes and goes.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "shorted",
      "text": "On lines that read alike because they are shorted together.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "interpolated",
      "text": "Not measured: the median of its neighbours.",
      "severity": 1,
      "counts": true,
      "scales": true
    },
    {
      "word": "unresolved",
      "text": "The cross-talk cannot be undone: its standard error exceeds its value.",
      "severity": 1,
      "counts": false,
      "scales": true
    },
    {
      "word": "unfamiliar",
      "text": "A network's estimate from an input unlike those it was trained with.",
      "severity": 1,
      "counts": false,
      "scales": true
    },
    {
      "word": "absent",
      "text": "There is no taxel at this crossing.",
      "severity": 0,
      "counts": false,
      "scales": false
    },
    {
      "word": "below-floor",
      "text": "Below what the recorder keeps: taken to be unloaded, and may be loaded by as much as reads that little.",
      "severity": 1,
      "counts": true,
      "scales": true
    }
  ]
};

/** @type {Wire.Hello} */
export const helloOfCone = {
  "kind": "hello",
  "protocol": 3,
  "program": "taxel 0",
  "sensor": {
    "name": "a cone",
    "rows": 4,
    "columns": 3,
    "pitch_mm": [
      8.0,
      10.0
    ],
    "taxel_area_mm2": 40.0,
    "cell_area_mm2": 80.0,
    "bits": 0,
    "max_count": 0.0,
    "has_load_law": true,
    "calibration": null,
    "exported": null,
    "positions_mm": null,
    "regions": [],
    "handle": {
      "rings": "columns",
      "angles": [
        0.0,
        1.0,
        2.0,
        3.0
      ],
      "radii_mm": [
        8.0,
        7.0,
        6.0
      ],
      "heights_mm": [
        0.0,
        9.9498743710662,
        19.8997487421324
      ],
      "narrowness": [
        1.0,
        0.875,
        0.75
      ],
      "slope": 0.1001674211615598,
      "closes": false
    }
  },
  "source": {
    "address": "sim:econe?hand",
    "type": "sim"
  },
  "methods": [
    "exact",
    "raw"
  ],
  "can_record": true,
  "sliders": [
    {
      "key": "r_mux_row_ohms",
      "label": "Row switch",
      "unit": "Ω",
      "value": 10.0,
      "type": "range",
      "min": 0.1,
      "max": 500.0,
      "step": 0.1,
      "logarithmic": true
    },
    {
      "key": "dead_row",
      "label": "Dead row",
      "unit": "",
      "value": 1.0,
      "type": "switch"
    }
  ],
  "file": null,
  "marks": [
    {
      "word": "good",
      "text": "Nothing is known against it.",
      "severity": 0,
      "counts": true,
      "scales": true
    },
    {
      "word": "open",
      "text": "On a line that is dead: the frame says nothing about it.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "saturated",
      "text": "At the converter's ceiling: the value is a lower bound.",
      "severity": 2,
      "counts": true,
      "scales": true
    },
    {
      "word": "stuck",
      "text": "Stuck at an end of the converter.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "spike",
      "text": "A spike against its neighbours or over time.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "flickering",
      "text": "On a line that comes and goes.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "shorted",
      "text": "On lines that read alike because they are shorted together.",
      "severity": 2,
      "counts": false,
      "scales": false
    },
    {
      "word": "interpolated",
      "text": "Not measured: the median of its neighbours.",
      "severity": 1,
      "counts": true,
      "scales": true
    },
    {
      "word": "unresolved",
      "text": "The cross-talk cannot be undone: its standard error exceeds its value.",
      "severity": 1,
      "counts": false,
      "scales": true
    },
    {
      "word": "unfamiliar",
      "text": "A network's estimate from an input unlike those it was trained with.",
      "severity": 1,
      "counts": false,
      "scales": true
    },
    {
      "word": "absent",
      "text": "There is no taxel at this crossing.",
      "severity": 0,
      "counts": false,
      "scales": false
    },
    {
      "word": "below-floor",
      "text": "Below what the recorder keeps: taken to be unloaded, and may be loaded by as much as reads that little.",
      "severity": 1,
      "counts": true,
      "scales": true
    }
  ]
};

/** @type {Wire.State} */
export const state = {
  "kind": "state",
  "device": {
    "state": "live",
    "text": "speaks taxel-1"
  },
  "frames_per_second": 99.5,
  "frames": 12345,
  "lost": 1,
  "corrupt": 2,
  "repeated": 3,
  "skipped": 4,
  "latency_ms": {
    "median": 1.25,
    "p99": 4.5
  },
  "clients": 2,
  "tare": {
    "on": true,
    "host_secs": 1795255200.5
  },
  "recording": {
    "name": "recordings/grip.mcap",
    "frames": 250,
    "bytes": 4096000,
    "secs": 2.5,
    "error": null
  },
  "method": "exact",
  "player": null,
  "sliders": {
    "dead_row": 1.0,
    "r_mux_row_ohms": 10.0
  },
  "bad_lines": {
    "rows": [
      1
    ],
    "columns": [
      0,
      2
    ],
    "suspect_rows": [],
    "suspect_columns": [
      7
    ]
  },
  "grip": null,
  "calibration": null
};

/** @type {Wire.State} */
export const stateOfFile = {
  "kind": "state",
  "device": {
    "state": "paused",
    "text": "playing run.mcap"
  },
  "frames_per_second": 0.0,
  "frames": 0,
  "lost": 0,
  "corrupt": 0,
  "repeated": 0,
  "skipped": 0,
  "latency_ms": {
    "median": 0.0,
    "p99": 0.0
  },
  "clients": 0,
  "tare": {
    "on": false,
    "host_secs": 0.0
  },
  "recording": {
    "name": "recordings/full.mcap",
    "frames": 0,
    "bytes": 0,
    "secs": 0.0,
    "error": "No space left on device (os error 28)"
  },
  "method": "",
  "player": {
    "playing": false,
    "speed": 1.0,
    "position_secs": 1.25,
    "duration_secs": 5.0,
    "frame": 125,
    "frames": 500
  },
  "sliders": {},
  "bad_lines": {
    "rows": [],
    "columns": [],
    "suspect_rows": [],
    "suspect_columns": []
  },
  "grip": null,
  "calibration": null
};

/** @type {Wire.State} */
export const stateOfGrip = {
  "kind": "state",
  "device": {
    "state": "waiting",
    "text": ""
  },
  "frames_per_second": 0.0,
  "frames": 0,
  "lost": 0,
  "corrupt": 0,
  "repeated": 0,
  "skipped": 0,
  "latency_ms": {
    "median": 0.0,
    "p99": 0.0
  },
  "clients": 0,
  "tare": {
    "on": false,
    "host_secs": 0.0
  },
  "recording": null,
  "method": "",
  "player": null,
  "sliders": {},
  "bad_lines": {
    "rows": [],
    "columns": [],
    "suspect_rows": [],
    "suspect_columns": []
  },
  "grip": {
    "phase": "rest",
    "remaining_secs": 41.5,
    "lasts_secs": 60.0,
    "person": "P01",
    "folder": "grips/P01/20261123-120000",
    "trial": 1,
    "trials": [
      {
        "hand": "right",
        "number": 1,
        "repeats": 1,
        "accepted": {
          "max_newtons": 412.5,
          "plateau_newtons": 380.25,
          "variation_percent": 2.5,
          "time_to_peak_secs": 0.75,
          "total_newtons": 650.0,
          "doubts": [
            "3 frames were lost"
          ]
        }
      },
      {
        "hand": "left",
        "number": 1,
        "repeats": 0,
        "accepted": null
      }
    ],
    "measured": {
      "max_newtons": 412.5,
      "plateau_newtons": 380.25,
      "variation_percent": 2.5,
      "time_to_peak_secs": 0.75,
      "total_newtons": 650.0,
      "doubts": [
        "3 frames were lost"
      ]
    },
    "protocol": {
      "name": "maximal grip",
      "posture": "seated, elbow at 90°",
      "hold_secs": 8.0,
      "rest_secs": 60.0,
      "target_newtons": [
        100.0,
        150.0
      ],
      "force": "grip force"
    },
    "warnings": [
      "the zero has drifted by 3 N"
    ],
    "trouble": "",
    "is_resumed": false,
    "is_simulated": true,
    "files": [
      "page.pdf"
    ]
  },
  "calibration": null
};

/** @type {Wire.State} */
export const stateOfCalibration = {
  "kind": "state",
  "device": {
    "state": "waiting",
    "text": ""
  },
  "frames_per_second": 0.0,
  "frames": 0,
  "lost": 0,
  "corrupt": 0,
  "repeated": 0,
  "skipped": 0,
  "latency_ms": {
    "median": 0.0,
    "p99": 0.0
  },
  "clients": 0,
  "tare": {
    "on": false,
    "host_secs": 0.0
  },
  "recording": null,
  "method": "",
  "player": null,
  "sliders": {},
  "bad_lines": {
    "rows": [],
    "columns": [],
    "suspect_rows": [],
    "suspect_columns": []
  },
  "grip": null,
  "calibration": {
    "phase": "elsewhere",
    "asked": {
      "row": 3,
      "column": 5,
      "load_g": 200.0,
      "is_among_others": true,
      "why": "this load tells most of the law and of the switches now",
      "is_again": false
    },
    "seen": {
      "row": 3,
      "column": 6,
      "is_there": false,
      "standing": 0.5,
      "problem": "row 3, column 6 is pressed most, not row 3, column 5"
    },
    "presses": [
      {
        "asked": {
          "row": 7,
          "column": 7,
          "load_g": 500.0,
          "is_among_others": false,
          "why": "",
          "is_again": false
        },
        "says_g": 491.5,
        "left_out": ""
      },
      {
        "asked": {
          "row": null,
          "column": null,
          "load_g": 5.0,
          "is_among_others": false,
          "why": "",
          "is_again": false
        },
        "says_g": null,
        "left_out": "undone by the operator"
      }
    ],
    "progress": [
      {
        "presses": 8,
        "mean_absolute_g": null,
        "standard_error_g": 0.0
      },
      {
        "presses": 9,
        "mean_absolute_g": 12.5,
        "standard_error_g": 2.25
      }
    ],
    "is_enough": false,
    "advice": "held-out presses are 12.5 ± 2.3 g off",
    "least_presses": 8,
    "loads_g": [
      50.0,
      200.0,
      500.0
    ],
    "sensor": "mat 16x16",
    "folder": "calibrations/2026-11-24-120000",
    "output": "calibrated.toml",
    "warnings": [
      "row 2: dead or flickering, not looked at"
    ],
    "doubts": [],
    "trouble": "",
    "is_resumed": true,
    "is_simulated": true,
    "files": []
  }
};

/** @type {Wire.Event} */
export const event = {
  "kind": "event",
  "host_secs": 1795255201.25,
  "text": "let go"
};

/** @type {Wire.Details} */
export const details = {
  "kind": "details",
  "taxels": [
    {
      "row": 1,
      "column": 2,
      "sequence": 41,
      "load": 0.25,
      "raw": 0.75,
      "counts": 1234,
      "mark": 0,
      "siemens": 0.000015,
      "half_width_95_newtons": 0.0625,
      "noise_only": true
    },
    {
      "row": 0,
      "column": 0,
      "sequence": 0,
      "load": 0.0,
      "raw": 0.0,
      "counts": 0,
      "mark": 1,
      "siemens": null,
      "half_width_95_newtons": null,
      "noise_only": false
    }
  ],
  "figures": {
    "sequence": 41,
    "total_newtons": 21.5,
    "total_half_width_95_newtons": 0.75,
    "contact_area_mm2": 12.5,
    "contact_area_half_width_95_mm2": 2.5,
    "noise_only": false,
    "why_unbounded": ""
  }
};

/** @type {Wire.Details} */
export const detailsUnbounded = {
  "kind": "details",
  "taxels": [],
  "figures": {
    "sequence": 42,
    "total_newtons": 210.0,
    "total_half_width_95_newtons": null,
    "contact_area_mm2": 12.5,
    "contact_area_half_width_95_mm2": null,
    "noise_only": true,
    "why_unbounded": "a taxel is at the converter's ceiling"
  }
};

/** @type {Wire.Curve} */
export const curve = {
  "kind": "curve",
  "method": "exact",
  "secs": [
    0.0,
    0.5,
    1.25
  ],
  "total_newtons": [
    0.0,
    null,
    12.5
  ],
  "peak_kilopascals": [
    0.0,
    null,
    62.5
  ],
  "contact_area_mm2": [
    0.0,
    null,
    9.0
  ]
};

/** @type {Wire.Answer} */
export const answer = {
  "kind": "answer",
  "to": 7,
  "ok": true,
  "text": "Tared"
};

/** @type {Wire.Answer} */
export const refusal = {
  "kind": "answer",
  "to": 8,
  "ok": false,
  "text": "3.0 N stand on the sensor: take the load off"
};
