"""Networks that see where a workpiece is sanded: trained on labelled images, and measured on held-out ones.

    python -m robofin_perception train --data out/images --model unet --out out/run
    python -m robofin_perception evaluate --run out/run --data out/images --out out/evaluation
"""
