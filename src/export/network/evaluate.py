"""The torque of a network that Torquescope trained, with NumPy alone.

    from evaluate import Network
    network = Network()                        # the folder of this file
    tau = network.torque(q, qd, qdd)           # each of shape (..., joints), SI units
    mass = network.mass_matrix(q)              # (..., joints, joints), of a structured Lagrangian

`python3 evaluate.py` computes the torque of the states in vectors.npz and ends with 0 if it is that of Torquescope.
weights.npz holds all arrays and, in model.json, what they are; weights.safetensors holds the same.
"""

import json
import pathlib
import sys

import numpy as np


def sigmoid(x):
    return 0.5 + 0.5 * np.tanh(0.5 * x)


def tanh(x):
    t = np.tanh(x)
    return t, 1 - t * t, -2 * t * (1 - t * t)


def logistic(x):
    s = sigmoid(x)
    return s, s * (1 - s), s * (1 - s) * (1 - 2 * s)


def softplus(x):
    s = sigmoid(x)
    return np.logaddexp(0, x), s, s * (1 - s)


def silu(x):
    s = sigmoid(x)
    return x * s, s + x * s * (1 - s), s * (1 - s) * (2 + x * (1 - 2 * s))


# An activation gives its value, its first and its second derivative.
ACTIVATIONS = {"tanh": tanh, "sigmoid": logistic, "softplus": softplus, "silu": silu}


class Network:
    """A jet is what a layer passes on: (x, x_dot, J, J_dot), where a dot is d/dt along the motion, and J[..., k, :] the derivative
    of x by the k-th of the variables."""

    def __init__(self, folder=pathlib.Path(__file__).parent):
        archive = np.load(pathlib.Path(folder) / "weights.npz")
        self.arrays = {name: archive[name] for name in archive.files}
        self.about = json.loads(self.arrays.pop("model.json"))
        model = self.about["architecture"]
        self.joints, self.features, self.scales = model["joints"], model["features"], model["scales"]
        self.weights = np.array(self.scales.get("joints") or np.ones(self.joints))
        terms = (({term: {}} if isinstance(term, str) else term) for term in model["terms"])
        self.terms = {kind: options for term in terms for kind, options in term.items()}

    def torque(self, q, qd, qdd):
        q, qd, qdd = np.broadcast_arrays(*(np.asarray(signal, dtype=float) for signal in (q, qd, qdd)))
        of_term = {
            "structured-lagrangian": self.structured,
            "black-box-lagrangian": self.black_box,
            "feed-forward": self.feed_forward,
            "friction": self.friction,
            "columns": self.effects,
        }
        return sum(of_term[kind](q, qd, qdd, **options) for kind, options in self.terms.items())

    def angles(self, skipped):
        """Sums of neighbouring angles as a matrix, without those of the first `skipped` joints."""
        n = self.joints
        if self.features != "link-angles":
            return np.eye(n)
        sums = [(first, last) for first in range(skipped, n) for last in range(first, n)]
        return np.array([[first <= joint <= last for joint in range(n)] for first, last in sums], dtype=float)

    def see(self, q, qd, skipped=0):
        """The jet of what networks see of the positions; its variables are the positions."""
        a = self.angles(skipped)
        jacobian = np.broadcast_to(a.T, q.shape[:-1] + a.T.shape)
        weights = self.weights[[np.flatnonzero(row)[-1] for row in a]]
        if self.features == "raw":
            return weights * q, weights * qd, weights * jacobian, 0 * jacobian
        angle, rate = q @ a.T, qd @ a.T
        cos, sin = weights * np.cos(angle), weights * np.sin(angle)
        beside = lambda left, right: np.concatenate([left, right], axis=-1)
        by = lambda row: row[..., None, :] * jacobian
        return (
            beside(cos, sin),
            beside(-sin * rate, cos * rate),
            beside(by(-sin), by(cos)),
            beside(by(-cos * rate), by(-sin * rate)),
        )

    def dense(self, name, jet, layers):
        """Linear layers x W + b, with the activation between them."""
        x, dot, jacobian, jacobian_dot = jet
        for layer in range(len(layers["hidden"]) + 1):
            w, b = (self.arrays[f"{name}/linear_{layer}/{part}"] for part in "wb")
            x, dot, jacobian, jacobian_dot = x @ w + b, dot @ w, jacobian @ w, jacobian_dot @ w
            if layer < len(layers["hidden"]):
                value, first, second = ACTIVATIONS[layers["activation"]](x)
                bent = (second * dot)[..., None, :] * jacobian
                jacobian_dot = first[..., None, :] * jacobian_dot + bent
                x, dot, jacobian = value, first * dot, first[..., None, :] * jacobian
        return x, dot, jacobian, jacobian_dot

    def inertia(self, q, qd, layers, positive):
        """H(q), its derivative along the motion, and those by each position (..., k, i, j)."""
        n = self.joints
        skipped = 1 if self.features == "link-angles" and n > 1 else 0
        o, dot, jacobian, _ = self.dense("mass_matrix", self.see(q, qd, skipped), layers)
        if positive:
            raw = o[..., :n] + positive["shift"]
            slope = np.concatenate([sigmoid(raw), np.ones_like(o[..., n:])], axis=-1)
            o = np.concatenate([np.logaddexp(0, raw) + positive["floor"], o[..., n:]], axis=-1)
            dot, jacobian = slope * dot, slope[..., None, :] * jacobian
        roots = np.sqrt(self.weights)
        scale = self.scales.get("inertia", self.scales["torque"]) * roots[:, None] * roots
        c, c_dot, c_by = self.triangle(o), self.triangle(dot), self.triangle(jacobian)
        turned = lambda matrix: np.swapaxes(matrix, -1, -2)
        if not positive:
            return tuple(scale * (matrix + turned(matrix)) for matrix in (c, c_dot, c_by))
        both = lambda change, c: scale * (change @ turned(c) + c @ turned(change))
        mass = scale * (c @ turned(c)) + positive["inertia"] * np.eye(n)
        return mass, both(c_dot, c), both(c_by, c[..., None, :, :])

    def triangle(self, packed):
        """A lower triangle: its diagonal first, then (1, 0), (2, 0), (2, 1), (3, 0), ..."""
        n = self.joints
        matrix = np.zeros(packed.shape[:-1] + (n, n))
        matrix[..., range(n), range(n)] = packed[..., :n]
        matrix[(..., *np.tril_indices(n, -1))] = packed[..., n:]
        return matrix

    def mass_matrix(self, q):
        q = np.asarray(q, dtype=float)
        return self.inertia(q, 0 * q, **self.terms["structured-lagrangian"])[0]

    def structured(self, q, qd, qdd, layers, positive):
        """H q'' + H' q' - 1/2 d(q'^T H q')/dq + dV/dq"""
        mass, dot, by = self.inertia(q, qd, layers, positive)
        gravity = self.scales["torque"] * self.dense("potential_energy", self.see(q, qd), layers)[2][..., 0]
        kinetic = np.einsum("...kij,...i,...j->...k", by, qd, qd)
        return np.einsum("...ij,...j->...i", mass, qdd) + np.einsum("...ij,...j->...i", dot, qd) - 0.5 * kinetic + gravity

    def black_box(self, q, qd, qdd, layers):
        """d/dt dL/dq' - dL/dq"""
        n, scale = self.joints, self.scales["velocity"]
        x, dot, jacobian, jacobian_dot = self.see(q, qd)
        wide = np.zeros(q.shape[:-1] + (2 * n, x.shape[-1] + n))
        wide_dot = wide.copy()
        wide[..., :n, :-n], wide_dot[..., :n, :-n] = jacobian, jacobian_dot
        wide[..., n:, -n:] = np.eye(n) / scale
        x, dot = np.concatenate([x, qd / scale], axis=-1), np.concatenate([dot, qdd / scale], axis=-1)
        _, _, jacobian, jacobian_dot = self.dense("lagrangian", (x, dot, wide, wide_dot), layers)
        return self.scales["torque"] * (jacobian_dot[..., n:, 0] - jacobian[..., :n, 0])

    def feed_forward(self, q, qd, qdd, layers, penalty):
        name = "epsilon" if any(kind.endswith("lagrangian") for kind in self.terms) else "inverse_model"
        seen = self.see(q, qd)[0]
        x = np.concatenate([seen, qd / self.scales["velocity"], qdd / self.scales["acceleration"]], axis=-1)
        nothing = np.zeros(x.shape[:-1] + (0, x.shape[-1]))
        return self.scales["torque"] * self.dense(name, (x, x, nothing, nothing), layers)[0]

    def friction(self, q, qd, qdd):
        coulomb, stribeck, log_v, damping = (self.arrays[f"friction/{part}"] for part in ("tau_cv", "tau_cs", "log_v", "d"))
        level = coulomb + stribeck * np.exp(-qd * qd * np.exp(-log_v))
        return self.scales["torque"] * (level * np.sign(qd) + damping * qd)

    def effects(self, q, qd, qdd, names):
        """Effects that were trained beside the network, by their formulas."""
        if not self.about["effects"]:
            return np.zeros(q.shape)
        from effects import effects

        return effects(q, qd, qdd)


if __name__ == "__main__":
    vectors = np.load(pathlib.Path(__file__).parent / "vectors.npz")
    q, qd, qdd, tau = (vectors[name] for name in ("q", "qd", "qdd", "tau"))
    network = Network()
    of_all, of_one = network.torque(q, qd, qdd) - tau, network.torque(q[0], qd[0], qdd[0]) - tau[0]
    worst = max(np.max(np.abs(of_all)), np.max(np.abs(of_one)))
    print("largest error:", worst)
    sys.exit(0 if worst <= 1e-9 * max(1.0, np.max(np.abs(tau))) else 1)
