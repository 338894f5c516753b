"""Pictures of sanded workpieces by an independent renderer, Blender's Cycles, with the labels of the program's images.

`python -m robofin_perception.independent --data SET --out DIR` renders the workpieces and doses of a set made by
`robofin dataset images` with other materials, lights, cameras and sensors. See docs/independent-renderer.md.
"""
