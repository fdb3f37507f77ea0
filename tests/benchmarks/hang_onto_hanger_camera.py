"""Share of seeds for which a product that the camera saw on a table ends at rest on the hanger.

Each seed varies the person, their world, which product stands there and where, and the camera's noise; the real
hanger is up to 5 mm off the map. No
solution counts as a failure, and so does a thing that was taken for something else.
Seeds were chosen before the first run: development used 1 to 99, the reported figure uses those from 1000.

    python tests/benchmarks/hang_onto_hanger_camera.py --first 1000 --count 100 --workers 2 --out DIR
"""

from __future__ import annotations

from seeds import main

if __name__ == "__main__":
    main("hang_onto_hanger_camera", __doc__)
