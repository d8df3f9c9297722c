"""Speed of training, or of prediction, of the same models in JAX, written as fast as a good user would.

    python -m venv venv && venv/bin/pip install -r requirements.txt
    venv/bin/python train.py [--steps 2000] [--batch 512] [--hidden 64 64] [--joints 3] [--inference]

Prints steps per second for each model, the best of several runs. One step is what `torquescope bench train` measures: a shuffled
batch is gathered from resident data, loss and gradient are computed, AdamW updates the weights; jitted, an epoch or a step at a
time, whichever is faster. The torque of the structured model uses one tangent and one reverse pass, as ours does.

With --inference: samples per second of the torque alone, jitted, in chunks of 2,000, the best call.
"""

import argparse
import time

import haiku as hk
import jax
import jax.numpy as jnp
import numpy as np
import optax


def features(q):
    return jnp.concatenate([jnp.cos(q), jnp.sin(q)], axis=-1)


def mlp(name, hidden, outputs):
    return hk.nets.MLP([*hidden, outputs], activation=jnp.tanh, name=name)


def lagrangian_torque(lagrangian, q, qd, qdd):
    """Euler-Lagrange for a batch of states: d/dt dL/dqd - dL/dq."""
    total = lambda q, qd: jnp.sum(lagrangian(q, qd))
    momentum = jax.grad(total, argnums=1)
    _, momentum_rate = jax.jvp(momentum, (q, qd), (qd, qdd))
    return momentum_rate - jax.grad(total, argnums=0)(q, qd)


def lower_triangle(o, n):
    diagonal = jax.nn.softplus(o[:, :n] + 2.0) + 0.1
    matrix = jnp.zeros((o.shape[0], n, n), o.dtype).at[:, jnp.arange(n), jnp.arange(n)].set(diagonal)
    rows, columns = np.tril_indices(n, -1)
    return matrix.at[:, rows, columns].set(o[:, n:])


def structured(hidden, n):
    def lagrangian(q, qd):
        z = features(q)
        triangle = lower_triangle(mlp("mass_matrix", hidden, n * (n + 1) // 2)(z), n)
        half = jnp.einsum("bij,bi->bj", triangle, qd)
        return 0.5 * jnp.sum(half**2, axis=-1) - mlp("potential_energy", hidden, 1)(z)[:, 0]

    return lagrangian


def black_box(hidden, n):
    return lambda q, qd: mlp("lagrangian", hidden, 1)(jnp.concatenate([features(q), qd], axis=-1))[:, 0]


def make_model(name, hidden, n):
    """(init, torque): torque(params, q, qd, qdd) gives torque and the penalised part."""
    if name == "ff-nn":
        net = hk.without_apply_rng(hk.transform(
            lambda q, qd, qdd: mlp("inverse_model", hidden, n)(jnp.concatenate([features(q), qd, qdd], axis=-1))))
        return net.init, lambda p, q, qd, qdd: (net.apply(p, q, qd, qdd), 0.0)
    energy = hk.without_apply_rng(hk.transform((black_box if name == "black-box-delan" else structured)(hidden, n)))
    rest = hk.without_apply_rng(hk.transform(
        lambda q, qd, qdd: mlp("epsilon", hidden, n)(jnp.concatenate([features(q), qd, qdd], axis=-1))))

    def init(key, q, qd, qdd):
        params = {"energy": energy.init(key, q, qd)}
        if name == "delan-ffnn":
            params["rest"] = rest.init(key, q, qd, qdd)
        if name == "delan-friction":
            params["friction"] = {k: jnp.full(n, 0.1) for k in ("tau_cv", "tau_cs", "log_v", "d")}
        return params

    def torque(params, q, qd, qdd):
        tau = lagrangian_torque(lambda q, qd: energy.apply(params["energy"], q, qd), q, qd, qdd)
        if name == "delan-friction":
            f = params["friction"]
            level = f["tau_cv"] + f["tau_cs"] * jnp.exp(-(qd**2) / jnp.exp(f["log_v"]))
            return tau + level * jnp.sign(qd) + f["d"] * qd, 0.0
        if name == "delan-ffnn":
            epsilon = rest.apply(params["rest"], q, qd, qdd)
            return tau + epsilon, 0.1 * jnp.mean(jnp.sum(epsilon**2, axis=-1))
        return tau, 0.0

    return init, torque


def measure(name, args):
    n, batch = args.joints, args.batch
    key = jax.random.PRNGKey(0)
    rows = jax.random.normal(key, (80_000, 4 * n), jnp.float32)
    weight = 1.0 / jnp.var(rows[:, 3 * n :], axis=0)
    init, torque = make_model(name, tuple(args.hidden), n)
    params = init(key, *jnp.split(rows[:batch], 4, axis=1)[:3])
    optimiser = optax.adamw(1e-4, weight_decay=1e-5)
    batches = len(rows) // batch

    def loss(params, q, qd, qdd, tau):
        predicted, penalty = torque(params, q, qd, qdd)
        return jnp.mean(jnp.sum(weight * (predicted - tau) ** 2, axis=-1)) + penalty

    def step(carry, picks):
        params, state = carry
        value, gradient = jax.value_and_grad(loss)(params, *jnp.split(rows[picks], 4, axis=1))
        updates, state = optimiser.update(gradient, state, params)
        return (optax.apply_updates(params, updates), state), value

    one_step = jax.jit(step, donate_argnums=0)
    whole_epoch = jax.jit(lambda carry, order: jax.lax.scan(step, carry, order))

    def by_steps(carry, order):
        for picks in order:
            carry, value = one_step(carry, picks)
        return carry, value

    def best_of(epoch):
        copy = jax.tree.map(jnp.array, params)
        carry = (copy, optimiser.init(copy))
        random, best = np.random.default_rng(0), float("inf")
        for _ in range(1 + max(args.steps // batches, 3)):
            start = time.perf_counter()
            order = random.permutation(len(rows))[: batches * batch].reshape(batches, batch)
            carry, value = epoch(carry, order)
            value.block_until_ready()
            best = min(best, (time.perf_counter() - start) / batches)
        return 1.0 / best

    # One call for an epoch or one for a step: which is faster depends on the model.
    return max(best_of(whole_epoch), best_of(by_steps))


def measure_inference(name, args):
    n, chunk = args.joints, 2_000
    key = jax.random.PRNGKey(0)
    motion = jnp.split(jax.random.normal(key, (chunk, 3 * n), jnp.float32), 3, axis=1)
    init, torque = make_model(name, tuple(args.hidden), n)
    params = init(key, *motion)
    predict = jax.jit(lambda params, q, qd, qdd: torque(params, q, qd, qdd)[0])
    best = float("inf")
    for _ in range(5 * args.steps):
        start = time.perf_counter()
        predict(params, *motion).block_until_ready()
        best = min(best, time.perf_counter() - start)
    return chunk / best


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--batch", type=int, default=512)
    parser.add_argument("--hidden", type=int, nargs="+", default=[64, 64])
    parser.add_argument("--joints", type=int, default=3)
    parser.add_argument("--inference", action="store_true")
    args = parser.parse_args()
    for name in ("ff-nn", "black-box-delan", "structured-delan", "delan-friction", "delan-ffnn"):
        if args.inference:
            print(f"{name:18} {measure_inference(name, args):8.3g} samples/s", flush=True)
        else:
            print(f"{name:18} {measure(name, args):8.0f} steps/s", flush=True)


if __name__ == "__main__":
    main()
