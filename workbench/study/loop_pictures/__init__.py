"""Pictures of linear systems and loops: over frequency, in the planes of gains and of poles, and over time.

The room knows plain data (frequencies, complex answers, periods, certified margins, poles, responses) and makes figures
of them; it knows no robot, law or loop. Read `frequency_curves` first, then `bode_pictures`.
"""
