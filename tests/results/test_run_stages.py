import json


def test_a_run_is_followed_back_to_its_data(store):
    name = store.run("sip_basis", {"mae_tau": [0.2]})
    run = store.outputs / "runs" / name / "run.json"
    record = json.loads(run.read_text(encoding="utf-8"))
    record["identity"]["upstream"] = {"data": "sip-data", "fit": "sip-fit"}
    run.write_text(json.dumps(record), encoding="utf-8")
    for kind, id, upstream in (("data", "sip-data", {}), ("fits", "sip-fit", {"data": "sip-data"})):
        origin = {"wall_s": 2.5, "git": {"commit": "abc", "clean": True}, "machine": {"cores_allowed": 2}}
        identity = {"upstream": upstream, "config": {"seeds": [0]}}
        made = {"id": id, "kind": kind, "name": "sip", "outcome": "ok", "identity": identity, "provenance": origin}
        made |= {"summary": {}, "files": {}, "error": None}
        (store.outputs / kind / id).mkdir(parents=True)
        (store.outputs / kind / id / "run.json").write_text(json.dumps(made), encoding="utf-8")

    stages = store.gathered().stages

    assert list(stages["stage"]) == ["data", "fit", "evaluation"]
    assert list(stages["id"]) == ["sip-data", "sip-fit", name]
    fit = stages.set_index("stage").loc["fit"]
    assert (fit["wall_s"], fit["commit"], bool(fit["clean"]), fit["cores"]) == (2.5, "abc", True, 2)
    assert json.loads(fit["config"]) == {"seeds": [0]}


def test_a_source_that_is_gone_is_left_out(store):
    name = store.run("sip_basis", {"mae_tau": [0.2]})
    run = store.outputs / "runs" / name / "run.json"
    record = json.loads(run.read_text(encoding="utf-8"))
    record["identity"]["upstream"] = {"data": "swept-away"}
    run.write_text(json.dumps(record), encoding="utf-8")
    assert list(store.gathered().stages["stage"]) == ["evaluation"]
