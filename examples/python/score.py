"""Score: a results file of a split; here one that was written by

    enfilade run --data homes --split val_unseen --agent random -o results.json
"""

import enfilade

episodes = enfilade.Dataset("homes").episodes("val_unseen")  # homes: made as in render.py
for metric, (mean, low, high) in episodes.score("results.json").means.items():
    print(f"{metric:20} {mean:8.3f}   [{low:.3f}, {high:.3f}]")
