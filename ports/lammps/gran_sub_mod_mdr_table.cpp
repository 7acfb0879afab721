/* -*- c++ -*-
   SPDX-License-Identifier: GPL-2.0-only
   The normal sub-model mdr/table of LAMMPS: a law that pymdr exported as mdr_table.h. See ports/README.md of pymdr.
*/

#include "gran_sub_mod_mdr_table.h"

#include "error.h"
#include "granular_model.h"
#include "mdr_table.h"

#include <cmath>

using namespace LAMMPS_NS;
using namespace Granular_NS;

#ifdef MDR_TABLE_PULL_OFF_INDENTATION
static constexpr int ADHERES = 1;
static constexpr double LEAST = MDR_TABLE_PULL_OFF_INDENTATION;
static constexpr double PULL = MDR_TABLE_LARGEST_PULL;
#else
static constexpr int ADHERES = 0;
static constexpr double LEAST = 0.0;
static constexpr double PULL = 0.0;
#endif

GranSubModNormalMDRTable::GranSubModNormalMDRTable(GranularModel *model, LAMMPS *program) :
    GranSubModNormal(model, program)
{
  num_coeffs = 1;
  contact_radius_flag = 1;
  cohesive_flag = ADHERES;
  beyond_contact = ADHERES;
}

void GranSubModNormalMDRTable::coeffs_to_local()
{
  damp = coeffs[0];
  if (damp < 0.0) error->all(FLERR, "Illegal mdr/table normal model: the damping is below 0");
}

void GranSubModNormalMDRTable::mix_coeffs(double *icoeffs, double *jcoeffs)
{
  coeffs[0] = std::sqrt(icoeffs[0] * jcoeffs[0]);
  coeffs_to_local();
}

bool GranSubModNormalMDRTable::touch()
{
  // a contact begins at zero overlap, and ends at pull-off
  const double reach = gm->radsum - (gm->touch ? LEAST : 0.0);
  return gm->rsq < reach * reach;
}

double GranSubModNormalMDRTable::pulloff_distance(double /*radi*/, double /*radj*/)
{
  return -LEAST;
}

double GranSubModNormalMDRTable::calculate_contact_radius()
{
  return mdr_table_radius(gm->delta);
}

double GranSubModNormalMDRTable::calculate_forces()
{
  if (!(gm->delta <= MDR_TABLE_LARGEST_INDENTATION))
    error->one(FLERR, "mdr/table: the overlap is beyond the table; export it with a larger --to");
  return mdr_table_force(gm->delta);
}

void GranSubModNormalMDRTable::set_fncrit()
{
  Fncrit = std::fabs(gm->Fntot) + 2.0 * PULL;
}
