"""Synthetic runs of every experiment, with plausible numbers, for a report that has all of its parts."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from synthetic_store import SyntheticStore

REGIMES = {"episodes": 0.25, "long": 2.5}


def errors(rng: np.random.Generator, centre: float, n: int = 5, spread: float = 0.3) -> list[float]:
    return list(centre * rng.lognormal(sigma=spread, size=n))


def learned(rng: np.random.Generator, tau: float, n: int = 5) -> dict[str, list[float]]:
    """Draw a plausible set of metrics for one fit, all tied to its force error."""
    factors = {
        "mae_tau": 1.0,
        "mae_qdd": 9.0,
        "median_ae_qdd": 4.0,
        "mae_L_raw": 150.0,
        "mae_L_relative": 20.0,
        "mae_L_canonical": 0.4,
        "mae_H_legendre": 5.0,
        "mae_H_centred": 3.0,
        "mae_H_sum": 60.0,
        "min_T": -50.0,
        "momentum_transform": 15.0,
        "onestep_euler_qd[0]": 0.0,
        "onestep_euler_qd[1]": 0.0,
        "rollout_qd[0]": 2.0,
        "rollout_qd[1]": 5.0,
        "fit_seconds": 12.0,
    }
    drawn = {metric: errors(rng, abs(factor) * tau, n) for metric, factor in factors.items()}
    drawn["min_T"] = [-value for value in drawn["min_T"]]
    drawn["onestep_euler_qd[0]"] = errors(rng, 0.05, n, 0.1)
    drawn["onestep_euler_qd[1]"] = errors(rng, 0.12, n, 0.1)
    drawn["skill_tau"] = [1 - value / 1.4 for value in drawn["mae_tau"]]
    drawn["min_eig_M"] = errors(rng, 0.02, n)
    return drawn


def learning_curve(rng: np.random.Generator, end: float, n: int = 5, steps: int = 600) -> pd.DataFrame:
    step = np.arange(steps)
    frames = []
    for member in range(n):
        curves = {
            "loss": end * (1 + 300 / (1 + step)) * rng.lognormal(sigma=0.15, size=steps),
            "min_eig_M": 0.04 - rng.lognormal(sigma=0.5) * np.exp(-step / 50),
        }
        frames += [
            pd.DataFrame({"member": member, "step": step, "name": name, "value": value})
            for name, value in curves.items()
        ]
    return pd.concat(frames, ignore_index=True)


def trajectory(rng: np.random.Generator, n: int = 5, points: int = 300) -> pd.DataFrame:
    t = 0.04 * np.arange(points)
    frames = []
    for member in range(n):
        for velocity, size in {"xd": 2.0, "thetad": 8.0}.items():
            plant = size * np.cumsum(rng.normal(size=points)) / np.sqrt(points)
            lines = {
                "plant": plant,
                "euler": plant + 0.02 * size * rng.normal(size=points),
                "model": plant + size * 0.002 * np.arange(points) ** 1.2 * rng.normal(),
            }
            frames += [
                pd.DataFrame({"member": member, "name": f"{source}.{velocity}", "t": t, "value": value})
                for source, value in lines.items()
            ]
    return pd.concat(frames, ignore_index=True)


def singular_values(seen: int, unseen: Sequence[str], n: int = 5) -> pd.DataFrame:
    rows = [
        (member, "D", order, 10.0 ** (-order / 15) if order < seen else 1e-16, text)
        for member in range(n)
        for order, text in enumerate([""] * seen + list(unseen))
    ]
    return pd.DataFrame(rows, columns=["member", "phase", "order", "value", "direction"])


def fill_double_pendulum(store: SyntheticStore, rng: np.random.Generator) -> None:
    """Run the experiments of the double pendulum, synthetically."""
    place = {"system": "dip", "basis": "fxf", "as_printed": False, "hidden": ""}
    for experiment in ("dip_identifiability", "dip_pretraining", "dip_neural"):
        store.anchors(experiment, trivial={"mae_tau": 0.66}, degenerate={"mae_tau": 0.08}, **place)
    unseen = {"main": ["a", "b"], "pretrain_only": ["a", "b", "(xd + 0.15 c)^2"], "joint": ["a", "b"]}
    for sequence, words in unseen.items():
        seen = 30 - len(words)
        metrics = {"rank": [seen] * 5, "condition_raw": [2e3] * 5, "condition_scaled": [50.0] * 5}
        grid = None if sequence == "main" else "product of 30"
        card = {**place, "optimiser": "least_squares", "sequence": sequence, "grid": grid, "tau_noise": 0.01}
        values = singular_values(seen, words)
        store.run("dip_identifiability", learned(rng, 1e-9) | metrics, identifiability=values, **card)
        for noise in (0.0, 0.1):
            gauge = {**card, "basis": "fxf_gauge", "tau_noise": noise, "energy_form": "sum"}
            store.run("dip_identifiability", learned(rng, 1e-9 + noise), **gauge)
    for regime in ("episodes", "long"):
        for optimiser, tau in (("adam_l1", 0.5), ("adam_cosine_l1", 0.004)):
            card = {**place, "regime": regime, "optimiser": optimiser, "seeds": list(range(8))}
            first = learned(rng, tau, 8) | {"mae_H_sum@free": errors(rng, 5e-4, 8)}
            pretrained = {"sequence": "pretrain", "grid": "product of 100", "pretraining_epochs": 300, "epochs": 1000}
            curves = learning_curve(rng, tau, 8)
            store.run("dip_pretraining", first, curves=curves, **card, **pretrained)
            alone = {"sequence": "main", "epochs": 1300}
            store.run("dip_pretraining", learned(rng, 10 * tau, 8), curves=learning_curve(rng, tau, 8), **card, **alone)
    store.run("dip_neural", learned(rng, 0.1) | {"trapped": [0, 0, 1, 0, 0]}, **{**place, "model": "structured"})


def fill_ports(store: SyntheticStore, rng: np.random.Generator) -> None:
    """Run the experiments on passivity, friction, composition and chains, synthetically."""
    for model, sign in (("port_hamiltonian", -1.0), ("blackbox", 1.0)):
        margins = [(member, step, "passivity_margin", sign * 1e-4) for member in range(2) for step in range(6)]
        names = ("free.plant.H", "free.model.H")
        energies = [(member, name, t, 1.0 + 0.1 * t) for member in range(2) for name in names for t in range(5)]
        store.run(
            "ph_passivity",
            {"passivity_margin_worst": [sign * 1e-4] * 2, "passivity_margin_plant": [sign * 1e-4] * 2},
            curves=pd.DataFrame(margins, columns=["member", "step", "name", "value"]),
            trajectories=pd.DataFrame(energies, columns=["member", "name", "t", "value"]),
            model=model,
            as_printed=False,
        )
    scratch = {"model": "lagrangian", "basis": "fxf", "hidden": ""}
    friction = learned(rng, 0.1) | {"damping_error": errors(rng, 0.01)}
    store.run("ph_damping", friction, system="dip", damping="[0.3, 0.01, 0.005]", as_printed=False, **scratch)
    mass = {"model": "hinged", "basis": "", "hidden": "", "model.parts": ["cart_rod_noisy"], "model.rod": "mass"}
    for samples in (10, 30, 1000):
        place = {
            "system": "dip",
            "n_train": samples,
            "tau_noise": 0.1,
            "as_printed": False,
            "optimiser": "least_squares",
        }
        for tau, card in ((1.0, scratch), (0.01, mass)):
            store.run("composition", learned(rng, tau / samples**0.5), **place, **card)
    chain = {f"chain_{name}_{n}": errors(rng, 0.01) for name in ("error", "seconds") for n in (2, 1000)}
    store.run("chains", chain, system="link", basis="spring", tau_noise=0.1, n_train=8000, as_printed=False)
    apart = np.random.default_rng(1)  # so that the numbers of other experiments stay
    for experiment in ("ph_interconnection", "ph_regularisation"):
        store.run(experiment, learned(apart, 0.1), system="dip", as_printed=False, model="port_hamiltonian", basis="")


def swing_up(links: int, starts: int = 6) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables of closed loops from random starts, every other one a success, and the motion of the first."""
    numbers = [""] if links == 1 else [str(number) for number in range(1, links + 1)]
    rows = [
        {
            "loop": loop, "member": 0, "controller": "energy", "setting": "sip" if links == 1 else "dip_best",
            "intervals": 20, "horizon_s": 0.8, "x_des": 0.8, "start": f"random {loop}", "task": "random",
            "mismatch": 0.0, "noise": 0.0, "disturbance": 0.0, "delay": 0.0, "success": loop % 2 == 0,
            "contact": loop == 1, "clearance_min_m": 0.01 * (1 - loop), "held_from_s": 4.0 if loop % 2 == 0 else None,
            "solve_ms_median": 5.0, "fallbacks": 0, "start_x": 0.1 * loop,
            **{f"start_theta{number}": 3.0 + 0.1 * loop for number in numbers},
        }
        for loop in range(starts)
    ]  # fmt: skip
    time = 0.04 * np.arange(200)
    angle = np.pi * np.exp(-time)
    series = {"x": 0.8 * (1 - np.exp(-time)), "T": angle**2, "V": np.cos(angle), "H": angle**2 + np.cos(angle)}
    series |= {"force": np.cos(time), "clearance": 0.3 + 0 * time}
    for number, name in enumerate(numbers, start=1):
        series |= {f"theta{name}": angle, f"theta{name}d": -angle}
        series |= {f"end{number}.x": number * 0.5 * np.sin(angle), f"end{number}.y": number * 0.5 * np.cos(angle)}
    moving = [(0, 0, 0.8, name, t, v) for name, values in series.items() for t, v in zip(time, values, strict=True)]
    disc = [(0, 0, 0.8, f"obstacle.{name}", 0.0, v) for name, v in {"x": 0.0, "y": 0.6, "radius": 0.3}.items()]
    columns = ["loop", "member", "x_des", "name", "t", "value"]
    return pd.DataFrame(rows), pd.DataFrame(moving + disc, columns=columns)


def fill_measured(store: SyntheticStore, rng: np.random.Generator) -> None:
    """Run the experiment without accelerations, synthetically."""
    place = {"system": "sip", "basis": "t1", "hidden": "", "as_printed": False}
    store.anchors("measured", trivial={"mae_tau": 1.25}, degenerate={"mae_tau": 0.1}, **place)
    for samples in (1000, 8000):
        for objective, tau in (("balance", 0.01), ("path", 0.001)):
            keys = {"data.sample_step": 0.01, "data.encoder_zero": 0.0, "data.q_noise": 0.001}
            card = {**place, **keys, "labels": "smoothed", "objective": objective, "n_train": samples}
            found = learned(rng, tau * (1000 / samples) ** 0.5)
            names = {"plant.theta": 1.0, "model.theta": 1.01, "standard_error.theta": 0.02, "episode": 3.0}
            rows = [(0, name, 0.04 * k, value) for name, value in names.items() for k in range(20)]
            moved = pd.DataFrame(rows, columns=["member", "name", "t", "value"]) if objective == "path" else None
            store.run("measured", found | {"bound_mae_qdd": found["mae_qdd"]}, trajectories=moved, **card)


def fill_related_work(store: SyntheticStore, rng: np.random.Generator) -> None:
    """Run a network of ours and a peer at two budgets, synthetically."""
    anchors = {"trivial": {"mae_tau": 1.25}, "degenerate": {"mae_tau": 0.1}}
    store.anchors("related_work", **anchors, system="sip", as_printed=False)
    for seconds in (1.7, 5.0):
        peer = {"model": "blackbox", "objective": "forward", "optimiser": "adam_budget", "optimiser.budget_s": seconds}
        ours = {"model": "structured", "optimiser": "levenberg_marquardt", "optimiser.budget_s": seconds}
        for card, tau in ((peer, 0.1 / seconds), (ours, 1e-5)):
            found = learned(rng, tau) | {"fit_seconds": [seconds] * 5}
            store.run("related_work", found, system="sip", labels="exact", tau_noise=0.0, n_train=1000, **card)


def fill_control(store: SyntheticStore) -> None:
    """Run the experiments of control, synthetically."""
    for experiment, system, links in (("sip_control", "sip", 1), ("dip_control", "dip", 2), ("swing_up", "dip", 2)):
        control, loops = swing_up(links)
        setting = "sip" if links == 1 else "dip_best"
        driven = {"control.kind": "energy", "control.name": setting, "task.name": "random"}
        driven |= {"task.mismatch": 0.0, "task.noise": 0.0}
        card = {"system": system, "model": "structured", "as_printed": False, "energies": "canonical", **driven}
        store.run(experiment, {"mae_tau": [0.01]}, control=control, closed_loops=loops, **card)
    for step in (0.04, 0.1):
        for model in ("truth", "lagrangian"):
            card = {"model": model, "control.kind": "energy", "control.name": "sip_printed", "control.time_step": step}
            control = swing_up(1)[0].assign(setting="sip_printed", success=step > 0.05)
            store.run("mpc_time_step", {"mae_tau": [0.01]}, control=control, **card)


def fill_sensitivity(outputs: Path, rng: np.random.Generator) -> None:
    """Run one assumption's trial, synthetically: one long run makes ten times the error."""
    tried = SyntheticStore(outputs, "sensitivity")
    tried.count = 0xF00
    runs = [tried.run("sip_basis", learned(rng, tau, 3), regime=regime) for regime, tau in REGIMES.items()]
    choice = {"assumption": "data_regime", "choice": "data=episodes", "alternative": "data=long"}
    case = {**choice, "claim": "C4a", "experiment": "sip_basis", "run": runs[0], "instead": runs[1]}
    path = outputs / "experiments" / "sensitivity" / "sip_basis.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"cases": [case]}), encoding="utf-8")


def fill(store: SyntheticStore) -> None:
    """Run every experiment, synthetically."""
    rng = np.random.default_rng(0)
    fill_sensitivity(store.outputs, np.random.default_rng(1))
    fill_control(store)
    fill_measured(store, np.random.default_rng(2))
    fill_related_work(store, np.random.default_rng(3))
    fill_ports(store, rng)
    fill_double_pendulum(store, rng)
    anchors = {"mae_tau": 1.4, "mae_qdd": 11.0, "onestep_euler_qd[0]": 0.05, "onestep_euler_qd[1]": 0.12}
    floor = {**anchors, "mae_tau": 0.12, "mae_qdd": 10.0}
    for experiment in ("sip_basis", "sip_forward_inverse", "sip_optimisers", "sip_energies"):
        store.anchors(experiment, trivial=anchors, degenerate=floor)
    for basis, hidden, objective, tau in (
        ("raw", "10", "inverse", 1.0),
        ("engineered", "10", "inverse", 0.4),
        ("t1", "", "inverse", 0.01),
        ("t1", "", "forward", 8.0),
        ("t2", "10", "inverse", 0.24),
        ("t2", "10", "forward", 2.2),
    ):
        store.run("sip_basis", learned(rng, tau), basis=basis, hidden=hidden, objective=objective)
    for basis, hidden, optimiser in (
        ("t1", "", "adam"),
        ("t2", "10", "adam"),
        ("t2", "2x32", "adam"),
        ("t2", "10", "levenberg_marquardt"),
    ):
        for objective, tau in (("inverse", 0.05), ("forward", 1.5)):
            bad = objective == "forward"
            status = ["ok"] * 4 + ["diverged at step 40" if bad else "ok"]
            card = {"basis": basis, "hidden": hidden, "optimiser": optimiser, "objective": objective}
            curves = learning_curve(rng, tau)
            store.run("sip_forward_inverse", learned(rng, tau), status=status, curves=curves, as_printed=False, **card)
    for regime, steps, labels, noise, tau in (
        ("episodes", 1000, "exact", 0.0, 0.25),
        ("episodes", 100, "exact", 0.0, 0.04),
        ("long", 1000, "exact", 0.0, 6.0),
        ("episodes", 1000, "differenced", 0.0, 0.9),
        ("episodes", 1000, "exact", 0.1, 0.3),
    ):
        place = {"regime": regime, "episode_steps": steps, "labels": labels, "tau_noise": noise}
        store.run("sip_regimes", learned(rng, tau), trajectories=trajectory(rng), **place)
        least = {**place, "basis": "t1", "optimiser": "least_squares", "as_printed": False, "hidden": "", "epochs": 0}
        store.run("sip_regimes", learned(rng, 1e-13 if labels == "exact" else 0.3), **least)
    for optimiser, curriculum, tau in (
        ("adam", [], 0.24),
        ("adam_cosine", [], 0.2),
        ("lbfgs", [], 0.05),
        ("levenberg_marquardt", [], 0.004),
        ("levenberg_marquardt", [100, 1000], 0.002),
    ):
        card = {"optimiser": optimiser, "curriculum": curriculum, "as_printed": False}
        store.run("sip_optimisers", learned(rng, tau), curves=learning_curve(rng, tau), **card)
    for sequence in ("main", "anchor", "pretrain_only", "pretrain", "joint"):
        form = "legendre" if sequence == "joint" else "sum"
        store.run("sip_energies", learned(rng, 0.02), sequence=sequence, energy_form=form, as_printed=False)
    transform = {"momentum_weight": 1.0, "momentum_hidden": "2x32", "as_printed": False}
    store.run("sip_energies", learned(rng, 1e-3), **transform)
    store.run("sip_energies", learned(rng, 1e-4), energies="canonical", as_printed=False)
    support = {"support_exact": [1, 1, 1, 1, 0], "false_terms": [0, 0, 0, 0, 2], "coefficient_error": errors(rng, 1e-4)}
    for optimiser in ("lasso", "adam_l1", "thresholded_least_squares"):
        store.run("sip_selection", support, optimiser=optimiser, tau_noise=0.1, qdd_noise=0.5, as_printed=False)
    row = {"name": "forward_vs_inverse", "ours": "inverse", "other": "forward", "threads": 1, "protocol": "paired, 30"}
    sizes = {"1x10": 1.07, "2x32": 1.6}
    steps = [
        {**row, "size": s, "members": 5, "ratio_median": r, "ratio_q25": 0.98 * r, "ratio_q75": 1.02 * r}
        | {"ours_ms": 1.4, "other_ms": 1.4 * r, "metric": ""}
        for s, r in sizes.items()
    ]
    race = {"metric": "MAE_qdd", "goal": 0.1, "starts": 5, "ours_reached": 5, "other_reached": 4}
    race |= {"ratio_least": 0.9, "ratio_greatest": 2.0}
    rivals = [{**steps[0], "name": "lnn_naive"}, {**steps[0], "name": "lnn_accuracy", **race}]
    store.bench([*steps, *rivals])
    store.run("sip_basis", {}, seeds=[0, 1], outcome="failed", basis="t2", hidden="2x500", objective="forward")
