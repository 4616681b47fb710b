{
 "about": "violation of it stays",
 "fingerprint": "cef78706ff6dc57dd65aab447b006176f66c0aadac58fbf66cb9e773ae771a69",
 "sought": {
  "x": 1.0,
  "k": 1.3526265735865217
 },
 "p": {
  "k": 1.3526265735865217
 },
 "x0": {
  "x": 1.0
 },
 "until": 0.2,
 "h": 0.05,
 "seed": 1,
 "value": "-0x1.0000000000000p+0",
 "error": "0x0.0p+0"
}
