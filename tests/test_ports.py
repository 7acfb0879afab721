"""Ports of exported laws to other programs, compiled against stubs of their interfaces and driven."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.drawing import first_of

import pymdr as mdr

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler (g++) on this machine")
WARNINGS = ["-Wall", "-Wextra", "-Wshadow", "-Werror"]
BODY = mdr.Elastic("10 kPa", 0.5)
CONTACTS = {
    "hertz": mdr.Contact(mdr.Sphere("5 um"), BODY),
    "jkr": mdr.Contact(mdr.Sphere("5 um"), BODY, adhesion=mdr.JKR("0.2 mJ/m^2")),
}
LAMMPS = """#pragma once
#define FLERR __FILE__, __LINE__
#include <stdexcept>
#include <string>
namespace LAMMPS_NS {
struct Error {
    [[noreturn]] void all(const char *, int, const std::string &text) { throw std::runtime_error(text); }
    [[noreturn]] void one(const char *, int, const std::string &text) { throw std::runtime_error(text); }
};
class LAMMPS { public: Error *error; };
namespace Granular_NS {
class GranularModel { public: double radsum, rsq, delta, Fntot; bool touch; };
class GranSubMod {
   public:
    GranSubMod(GranularModel *model, LAMMPS *lmp) : gm(model), error(lmp->error) {}
    virtual ~GranSubMod() {}
    virtual void mix_coeffs(double *, double *) {}
    virtual void coeffs_to_local() {}
    int num_coeffs = 0, beyond_contact = 0, contact_radius_flag = 0;
    double *coeffs = nullptr;
    GranularModel *gm;
   protected:
    Error *error;
};
class GranSubModNormal : public GranSubMod {
   public:
    GranSubModNormal(GranularModel *model, LAMMPS *lmp) : GranSubMod(model, lmp) {}
    virtual bool touch() { return false; }
    virtual double pulloff_distance(double, double) { return 0.0; }
    virtual double calculate_contact_radius() { return 0.0; }
    virtual double calculate_forces() = 0;
    virtual void set_fncrit() {}
    double damp = 0.0, Fncrit = 0.0;
    int cohesive_flag = 0;
};
}
}
"""
DRIVER = """#include "gran_sub_mod_mdr_table.h"
#include <cstdio>
#include <cstdlib>
using namespace LAMMPS_NS;
using namespace Granular_NS;
int main(int, char **overlaps)
{
    Error error;
    LAMMPS lmp{&error};
    GranularModel gm{2e-5, 0.0, 0.0, 0.0, false};
    GranSubModNormalMDRTable law(&gm, &lmp);
    double damping[] = {0.0};
    law.coeffs = damping;
    law.coeffs_to_local();
    while (*++overlaps) {
        gm.delta = std::atof(*overlaps);
        gm.rsq = (gm.radsum - gm.delta) * (gm.radsum - gm.delta);
        gm.touch = law.touch();
        try {
            std::printf("%.17g %.17g\\n", gm.touch ? law.calculate_forces() : 0.0,
                        gm.touch ? law.calculate_contact_radius() : 0.0);
        } catch (const std::runtime_error &refusal) {
            std::printf("refused: %s\\n", refusal.what());
        }
    }
}
"""
YADE = """#include <memory>
#include <stdexcept>
namespace boost { using std::shared_ptr; }
struct Vector3r { double x, y, z; };
inline Vector3r operator*(double a, const Vector3r &v) { return {a * v.x, a * v.y, a * v.z}; }
inline Vector3r operator-(const Vector3r &v) { return -1.0 * v; }
struct IGeom { virtual ~IGeom() {} };
struct IPhys { virtual ~IPhys() {} };
struct ScGeom : IGeom { double penetrationDepth; Vector3r normal; };
struct NormPhys : IPhys { double kn; Vector3r normalForce; };
struct Interaction { int getId1() const { return 0; } int getId2() const { return 1; } };
struct Forces { Vector3r on[2]; void addForce(int id, const Vector3r &f) { on[id] = f; } };
struct Scene { Forces forces; };
struct Law2_ScGeom_NormPhys_Grain {
    Scene *scene;
    bool go(boost::shared_ptr<IGeom> &, boost::shared_ptr<IPhys> &, Interaction *);
};
"""
MOVED = """#include <cstdio>
int main()
{
    Scene scene;
    Law2_ScGeom_NormPhys_Grain law{&scene};
    auto geom = std::make_shared<ScGeom>();
    auto phys = std::make_shared<NormPhys>();
    boost::shared_ptr<IGeom> g = geom;
    boost::shared_ptr<IPhys> p = phys;
    Interaction contact;
    geom->normal = {1.0, 0.0, 0.0};
    geom->penetrationDepth = 5e-7;
    const bool kept = law.go(g, p, &contact);
    geom->penetrationDepth = -1e-9;
    std::printf("%d %.17g %.17g %.17g %d\\n", kept, scene.forces.on[0].x, scene.forces.on[1].x, phys->kn,
                law.go(g, p, &contact));
}
"""


def run(folder, *arguments):
    flags = ["-std=c++17", *WARNINGS, "-I", str(folder)]
    subprocess.run(
        ["g++", *flags, *map(str, folder.glob("*.cpp")), "-o", str(folder / "run"), "-lm"], check=True
    )
    given = [str(folder / "run"), *map(repr, arguments)]
    return subprocess.run(given, check=True, capture_output=True, text=True).stdout.splitlines()


@pytest.mark.parametrize("name", first_of(["jkr", "hertz"]))
def test_the_sub_model_of_lammps(name, tmp_path):
    law = mdr.export_law(CONTACTS[name], "1 um")
    law.to_c(tmp_path / "mdr_table.h")
    for file in (ROOT / "ports" / "lammps").glob("gran_sub_mod_mdr_table.*"):
        shutil.copy(file, tmp_path)
    (tmp_path / "granular_model.h").write_text(LAMMPS)
    for stub in ("gran_sub_mod.h", "gran_sub_mod_normal.h", "error.h"):
        (tmp_path / stub).write_text('#include "granular_model.h"\n')
    (tmp_path / "main.cpp").write_text(DRIVER)
    off = law.pull_off.indentation if law.pull_off else 0.0
    depths = [-1e-8, 1e-9, 5e-7, 1e-6, 2e-8, 0.5 * off, 1.01 * off - 1e-12, 0.5 * off - 1e-12, 3e-7]
    lines = run(tmp_path, *depths, 1.1e-6)
    stepper = mdr.Stepper(CONTACTS[name], "1 um")
    expected = [(stepper.advance(d).normal, stepper.contact_radius) for d in depths]
    computed = np.array([line.split() for line in lines[:-1]], dtype=float)
    for i, size in enumerate(np.abs(expected).max(axis=0)):
        assert computed[:, i] == pytest.approx(np.array(expected)[:, i], abs=1e-5 * size)
    assert lines[-1] == "refused: mdr/table: the overlap is beyond the table; export it with a larger --to"


def test_the_functor_for_yade(tmp_path):
    law = mdr.export_law(CONTACTS["hertz"], "1 um")
    law.to_c(tmp_path / "grain.h")
    page = (ROOT / "docs" / "law.md").read_text()
    functor = re.search(r":caption: Law2_ScGeom_NormPhys_Grain.cpp\n\n(.*?):::", page, re.DOTALL)[1]
    (tmp_path / "functor.cpp").write_text(YADE + functor + MOVED)
    (line,) = run(tmp_path)
    kept, one, other, stiffness, ended = map(float, line.split())
    force = float(law.force(5e-7))
    assert (kept, ended) == (1.0, 0.0)
    assert one == -other
    assert [other, stiffness] == pytest.approx([force, float(law.stiffness(5e-7))], rel=1e-13)
