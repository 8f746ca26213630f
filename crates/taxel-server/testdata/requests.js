// Everything that the page may ask for: checked against its types by tsc, and read by crates/taxel-server/src/tests/wire.rs,
// which takes the list as JSON.

/** @type {Wire.Request[]} */
export const requests = [
  { "do": "tare" },
  { "do": "tare", "force": true },
  { "do": "untare" },
  { "do": "record" },
  { "do": "record", "name": "subject 1" },
  { "do": "stop" },
  { "do": "event", "text": "let go" },
  { "do": "method", "name": "exact" },
  { "do": "slider", "key": "noise_counts", "value": 2.5 },
  { "do": "play" },
  { "do": "pause" },
  { "do": "seek", "secs": 1.25 },
  { "do": "speed", "factor": 0.5 },
  { "do": "grip", "step": { "is": "begin", "person": "P01", "note": "glove" } },
  { "do": "grip", "step": { "is": "zero" } },
  { "do": "grip", "step": { "is": "zero", "force": true } },
  { "do": "grip", "step": { "is": "start" } },
  { "do": "grip", "step": { "is": "cancel" } },
  { "do": "grip", "step": { "is": "accept" } },
  { "do": "grip", "step": { "is": "repeat", "reason": "the hand slipped" } },
  { "do": "grip", "step": { "is": "skip-rest" } },
  { "do": "grip", "step": { "is": "finish" } },
  { "do": "watch", "taxels": [[3, 7], [0, 0]], "figures": false },
  { "do": "watch", "taxels": [], "figures": true },
  { "do": "rate", "frames_per_second": 60 },
  { "do": "got", "sequence": 9 }
];
