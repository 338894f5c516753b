"""SAM 2 (Ravi et al. 2024) with a frozen image encoder, a box as prompt, and one mask."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from torch import Tensor

from .data import Box, Example
from .errors import WrongUse
from .models import Segmenter, Tensors, pixels

#: Means and deviations of the images on which SAM 2 was trained.
MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class Sam2(Segmenter):
    """Prompt encoder and mask decoder are trained; what is before them is frozen, and its outputs can be kept.

    Frozen are the image encoder, the embedding of a missing memory and the decoder's two convolutions of the encoder's
    fine features, since these are applied before the outputs are kept.
    """

    kind = "sam2"

    def __init__(self, sam: Any) -> None:
        super().__init__()
        decoder = sam.mask_decoder
        # Only the first of the decoder's masks is trained: no other one may take its place.
        decoder.dynamic_multimask_via_stability = False
        sam.config.mask_decoder_config.dynamic_multimask_via_stability = False
        self._still = {"vision_encoder": sam.vision_encoder, "conv_s0": decoder.conv_s0, "conv_s1": decoder.conv_s1}
        sam.requires_grad_(False)
        for part in (sam.prompt_encoder, decoder):
            part.requires_grad_(True)
        for part in self._still.values():
            part.requires_grad_(False)
        self.sam = sam
        self.side = int(sam.prompt_encoder.input_image_size)
        self.grid = (self.side // 4, self.side // 4)

    @classmethod
    def random(cls) -> Sam2:
        from transformers import Sam2Model

        return cls(Sam2Model(_small()))

    @classmethod
    def read(cls, name: str) -> Sam2:
        from transformers import Sam2Model

        try:
            read: Any = Sam2Model.from_pretrained(name, dtype=torch.float32, output_loading_info=True)
        except (OSError, ValueError, RuntimeError, SafetensorError) as error:
            raise _refused(name, str(error).strip().partition("\n")[0]) from None
        sam, loading = read
        if loading["missing_keys"]:
            raise _refused(name, f"it lacks {min(loading['missing_keys'])}")
        return cls(sam)

    def frozen(self) -> Tensors:
        weights = {f"{part}.{name}": weight for part, module in self._still.items()
                   for name, weight in module.state_dict().items()}
        return {**weights, "no_memory_embedding": self.sam.no_memory_embedding}

    def frame(self, example: Example) -> Box:
        height, width = example.label.shape
        return 0, 0, width, height

    @torch.no_grad()
    def encode(self, example: Example) -> Tensors:
        frame = self.frame(example)
        device = self.sam.no_memory_embedding.device
        image = pixels(example.image, frame, (self.side, self.side)).to(device).float() / 255
        mean, deviation = (torch.tensor(each, device=device)[:, None, None] for each in (MEAN, DEVIATION))
        features = self.sam.get_image_embeddings(((image - mean) / deviation)[None])
        scale = torch.tensor([self.side / frame[2], self.side / frame[3]]).repeat(2)
        kept = {f"features{level}": each[0].half().cpu().contiguous() for level, each in enumerate(features)}
        return {**kept, "box": torch.tensor(example.box) * scale}

    def forward(self, batch: Tensors) -> tuple[Tensor, Tensor]:
        features = [batch[f"features{level}"].float() for level in range(len(batch) - 1)]
        answer = self.sam(image_embeddings=features, input_boxes=batch["box"][:, None], multimask_output=False)
        return answer.pred_masks[:, 0, 0], answer.object_score_logits[:, 0, 0]

    def save(self, folder: Path) -> None:
        self.sam.save_pretrained(folder)


def _refused(name: str, why: str) -> WrongUse:
    return WrongUse(f"{name!r} is no model that can be read ({why}); accepted are unet, sam2-random, a folder with "
                    "config.json and model.safetensors of SAM 2, or the name of such a model on the hub, as "
                    "facebook/sam2.1-hiera-tiny")


def _small() -> Any:
    """A configuration that trains in seconds: images of 128 x 128 pixels."""
    from transformers import Sam2Config, Sam2HieraDetConfig, Sam2MaskDecoderConfig, Sam2PromptEncoderConfig
    from transformers import Sam2VisionConfig

    side, width, stages = 128, 64, [16, 32, 64, 128]
    backbone = Sam2HieraDetConfig(
        hidden_size=stages[0], image_size=[side, side], blocks_per_stage=[1, 1, 2, 1], embed_dim_per_stage=stages,
        num_attention_heads_per_stage=[1, 2, 4, 8], window_size_per_stage=[8, 4, 4, 4], global_attention_blocks=[3],
        initializer_range=0.1)
    vision = Sam2VisionConfig(
        backbone_config=backbone, backbone_channel_list=stages[::-1], fpn_hidden_size=width,
        backbone_feature_sizes=[[side // stride] * 2 for stride in (4, 8, 16)], initializer_range=0.1)
    return Sam2Config(
        vision_config=vision, initializer_range=0.1,
        prompt_encoder_config=Sam2PromptEncoderConfig(hidden_size=width, image_size=side),
        mask_decoder_config=Sam2MaskDecoderConfig(
            hidden_size=width, mlp_dim=128, num_attention_heads=4, iou_head_hidden_dim=width))
