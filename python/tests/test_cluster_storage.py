"""Results at an address: a server of S3 on this machine gets the bytes of one machine, and only what is missing."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import robofin

if missing := [name for name in ("ray", "s3fs", "moto", "flask") if not importlib.util.find_spec(name)]:
    pytest.skip(f"results at an address are NOT TESTED: {', '.join(missing)} missing", allow_module_level=True)

import boto3
import ray
from cluster_checks import IMAGES, PART, ROOT, SET, assert_same
from moto.server import ThreadedMotoServer

from robofin import cluster

BUCKET = "robofin"
ENVIRONMENT = {"AWS_ACCESS_KEY_ID": "testing", "AWS_SECRET_ACCESS_KEY": "testing", "AWS_DEFAULT_REGION": "us-east-1",
               "RAY_worker_niceness": "0"}


@pytest.fixture(scope="module")
def bucket() -> Iterator[Any]:
    """A bucket of a server on this machine; the cluster's workers get its endpoint and keys by their environment."""
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {**ENVIRONMENT, "AWS_ENDPOINT_URL": f"http://{host}:{port}"}.items():
            patch.setenv(name, value)
        made = boto3.resource("s3").Bucket(BUCKET)
        made.create()
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
        yield made
        ray.shutdown()
        server.stop()


def fetched(bucket: Any, prefix: str, folder: Path) -> Path:
    """The objects below a prefix as files in a folder."""
    for each in bucket.objects.filter(Prefix=f"{prefix}/"):
        place = folder / each.key.removeprefix(f"{prefix}/")
        place.parent.mkdir(parents=True, exist_ok=True)
        bucket.download_file(each.key, str(place))
    return folder


def times(bucket: Any, prefix: str) -> dict[str, Any]:
    """When each object below a prefix was written."""
    return {each.key: each.last_modified for each in bucket.objects.filter(Prefix=f"{prefix}/")}


def test_assets_have_the_bytes_of_one_machine_and_only_missing_ones_are_made_again(bucket: Any, tmp_path: Path) -> None:
    robofin.run("dataset", PART, "--out", tmp_path / "one", *SET)
    ended: list[tuple[int, int]] = []
    address = f"s3://{BUCKET}/set"
    answer = cluster.assets(PART, out=address, flags=SET, progress=lambda *counts: ended.append(counts))
    assert answer[-1]["there"] == 4 and ended == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert_same(tmp_path / "one", fetched(bucket, "set", tmp_path / "first"))
    before = times(bucket, "set")
    cluster.assets(PART, out=address, flags=SET)
    assert times(bucket, "set") == before
    gone = next(key for key in before if key.endswith("asset.json"))
    bucket.Object(gone).delete()
    cluster.assets(PART, out=address, flags=SET)
    assert_same(tmp_path / "one", fetched(bucket, "set", tmp_path / "second"))
    folder = gone.removesuffix("asset.json")
    changed = {key for key, time in times(bucket, "set").items() if before[key] != time and "/assets/" in key}
    assert changed and all(key.startswith(folder) for key in changed)


def test_a_part_that_cannot_be_welded_is_refused_and_its_failure_is_kept(bucket: Any, tmp_path: Path) -> None:
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(robofin.RoboFinError, match=f"1 of 2 items failed; failures.jsonl in s3://{BUCKET}/broken"):
        cluster.assets(PART, tmp_path / "open.obj", out=f"s3://{BUCKET}/broken", flags=[*SET, "--limit", "2"])
    keys = times(bucket, "broken")
    assert len([key for key in keys if key.endswith("asset.json")]) == 1
    assert len([key for key in keys if "/failures/" in key]) == 1 and "broken/manifest.jsonl" in keys


def test_images_have_the_bytes_of_one_machine(bucket: Any, tmp_path: Path) -> None:
    robofin.run("dataset", "images", "--out", tmp_path / "one", *IMAGES)
    cluster.images(f"s3://{BUCKET}/images", flags=IMAGES)
    assert_same(tmp_path / "one", fetched(bucket, "images", tmp_path / "ray"))
    before = times(bucket, "images")
    cluster.images(f"s3://{BUCKET}/images", flags=IMAGES)
    assert times(bucket, "images") == before


def test_studies_have_the_bytes_of_one_machine(bucket: Any, tmp_path: Path) -> None:
    table = ROOT / "data/tables/belt-sanding"
    address = f"s3://{BUCKET}/studies"
    assert cluster.studies([table], address) == [f"{address}/belt-sanding"]
    robofin.Campaign(table).study(tmp_path / "one")
    assert_same(tmp_path / "one", fetched(bucket, "studies/belt-sanding", tmp_path / "ray"))
    before = times(bucket, "studies")
    cluster.studies([table], address)
    assert times(bucket, "studies") == before


def test_episodes_have_the_figures_of_one_machine(bucket: Any) -> None:
    welds: dict[str, Any] = {"split": "held-out", "count": 1}
    address = f"s3://{BUCKET}/raster"
    found = cluster.episodes("raster", welds, [3, 1], address, time_limit=1.0)
    alone = robofin.evaluate("raster", robofin.suite(**welds), [3, 1], time_limit=1.0)
    assert np.array_equal(found.values, alone.values)
    before = times(bucket, "raster")
    again = cluster.episodes("raster", welds, [1, 2, 3], address, time_limit=1.0)
    assert np.array_equal(again.values[[2, 0]], found.values)
    assert {key: time for key, time in times(bucket, "raster").items() if "episode" in key and key in before} == {
        key: time for key, time in before.items() if "episode" in key}
    with pytest.raises(robofin.WrongUse, match="another folder is accepted"):
        cluster.episodes("oracle", welds, [1], address, time_limit=1.0)


@pytest.mark.parametrize("address, message", [("s3://no-such-bucket/set", "no-such-bucket/set cannot be written"),
                                              ("nowhere://set", "nowhere://set cannot be opened")])
def test_an_address_that_cannot_be_written_is_refused_before_any_work(bucket: Any, address: str, message: str) -> None:
    with pytest.raises(robofin.WrongUse, match=message):
        cluster.assets(PART, out=address, flags=SET)
    with pytest.raises(robofin.WrongUse, match=message):
        cluster.images(address, flags=IMAGES)
    with pytest.raises(robofin.WrongUse, match=message):
        cluster.studies([ROOT / "data/tables/belt-sanding"], address)
    with pytest.raises(robofin.WrongUse, match=message):
        cluster.episodes("raster", {"count": 1}, [1], address)
    assert [each.name for each in boto3.resource("s3").buckets.all()] == [BUCKET]


def test_an_address_of_files_is_a_folder(bucket: Any, tmp_path: Path) -> None:
    robofin.run("dataset", PART, "--out", tmp_path / "one", *SET[2:])
    cluster.assets(PART, out=f"file://{tmp_path}/sets/one", flags=SET[2:])
    assert_same(tmp_path / "one", tmp_path / "sets/one")


def test_other_flags_than_those_of_the_set_are_refused_before_any_work(bucket: Any) -> None:
    address = f"s3://{BUCKET}/flags"
    cluster.assets(PART, out=address, flags=[*SET, "--limit", "1"])
    before = times(bucket, "flags")
    with pytest.raises(robofin.WrongUse, match="started with other flags: seed"):
        cluster.assets(PART, out=address, flags=[*SET[:2], "--seed", "8", *SET[4:], "--limit", "1"])
    assert times(bucket, "flags") == before
