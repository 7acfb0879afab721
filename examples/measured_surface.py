"""
From a measured surface to a stiffness
======================================

A file of heights is read, levelled and analysed: its power spectrum follows a self-affine law over a decade and a half. The law
defines a randomly rough surface, and the line of springs gives its stiffness under a load.

Run it on your own surface with ``python measured_surface.py FILE``, in any format of SurfaceTopography (``pip install
'pymdr[topography]'``). Without a file it generates one.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import pymdr as mdr

named = sys.argv[1] if __name__ == "__main__" and len(sys.argv) > 1 else None


def made(folder):
    """A text of 256 x 256 heights of a surface with H = 0.8 and a slope of its holder, cut out of a larger one."""
    rng = np.random.default_rng(4)
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(768), np.fft.fftfreq(768)))
    q[0, 0] = np.inf
    root = np.where(q < 0.25, q**-1.8, 0.0)
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal(q.shape)) * root).real[:256, :256]
    heights = 20.0 * heights / heights.std() + np.linspace(0.0, 150.0, 256)
    file = Path(folder) / "surface.csv"
    head = "Width: 10 um\nHeight: 10 um\nValue units: nm"
    np.savetxt(file, heights, delimiter=",", fmt="%.3f", header=head)
    return file


with TemporaryDirectory() as folder:
    surface = mdr.read_topography(named or made(folder), missing="interpolate", detrend="plane")
print("\n".join(surface.steps))

# %%
# The spectrum of one patch with its scatter, and the widest self-affine range:
spectrum = mdr.power_spectrum(surface, tip_radius="10 nm")
print(spectrum)
figure = spectrum.plot()
figure.savefig("measured_surface.png")
print("figure saved as measured_surface.png")
fit = spectrum.fit
print(f"H = {fit.hurst:.3f} +- {fit.hurst_error:.3f}")
assert named or abs(fit.hurst - 0.8) < 3.0 * fit.hurst_error < 0.15

# %%
# The rough surface of this law has the size and the rms height of the patch. Its waves end where the spectrum does: the stiffness is
# that of the resolved roughness.
rough = fit.rough_surface(seed=1)
assert abs(rough.rms / float(np.std(surface.heights)) - 1.0) < 1e-12
steel = mdr.Elastic("210 GPa", 0.3)
pressed = mdr.press_rough(rough, steel, normal_force=np.geomspace(1e-5, 1e-1, 17))
print(pressed)
figure = pressed.plot()
figure.savefig("measured_surface_2.png")
print("figure saved as measured_surface_2.png")

# %%
# It is not a single bump, and is refused as one:
try:
    mdr.azimuthal_profile(surface)
except mdr.ProblemError as refusal:
    print(refusal)
else:
    assert named
