/* -*- c++ -*-
   SPDX-License-Identifier: GPL-2.0-only
   The normal sub-model mdr/table of LAMMPS: a law that pymdr exported as mdr_table.h. See ports/README.md of pymdr.
*/

#ifdef GRAN_SUB_MOD_CLASS
// clang-format off
GranSubModStyle(mdr/table,GranSubModNormalMDRTable,NORMAL);
// clang-format on
#else

#ifndef GRAN_SUB_MOD_MDR_TABLE_H
#define GRAN_SUB_MOD_MDR_TABLE_H

#include "gran_sub_mod.h"
#include "gran_sub_mod_normal.h"

namespace LAMMPS_NS {
namespace Granular_NS {

  class GranSubModNormalMDRTable : public GranSubModNormal {
   public:
    GranSubModNormalMDRTable(class GranularModel *, class LAMMPS *);
    void coeffs_to_local() override;
    void mix_coeffs(double *, double *) override;
    bool touch() override;
    double pulloff_distance(double, double) override;
    double calculate_contact_radius() override;
    double calculate_forces() override;
    void set_fncrit() override;
  };

}    // namespace Granular_NS
}    // namespace LAMMPS_NS

#endif /* GRAN_SUB_MOD_MDR_TABLE_H */
#endif /* GRAN_SUB_MOD_CLASS */
