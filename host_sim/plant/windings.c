/* SPDX-License-Identifier: MIT */
#include "windings.h"

#include "pair.h"

#include <math.h>

/* 2/3 sum of weight_k n_k n_k^T: the identity for weights of 1. */
static plant_symmetric_t of_phases(const double weight[PLANT_LEGS])
{
    const double others = weight[1] + weight[2];
    return (plant_symmetric_t){
        PLANT_CLARKE * (weight[0] + 0.25 * others),
        PLANT_CLARKE * 0.25 * PLANT_SQRT3 * (weight[2] - weight[1]),
        PLANT_CLARKE * 0.75 * others,
    };
}

static plant_symmetric_t inverse_of(const plant_symmetric_t *m)
{
    const double determinant = m->aa * m->bb - m->ab * m->ab;
    return (plant_symmetric_t){m->bb / determinant, -m->ab / determinant, m->aa / determinant};
}

/* w e w */
static plant_symmetric_t on_both_sides(const plant_symmetric_t *w, const plant_symmetric_t *e)
{
    const plant_vector_t first = plant_symmetric_times(e, (plant_vector_t){w->aa, w->ab});
    const plant_vector_t second = plant_symmetric_times(e, (plant_vector_t){w->ab, w->bb});
    const plant_vector_t a = plant_symmetric_times(w, first);
    const plant_vector_t b = plant_symmetric_times(w, second);
    return (plant_symmetric_t){a.alpha, b.alpha, b.beta};
}

static double largest_eigenvalue(const plant_symmetric_t *m)
{
    const double half = 0.5 * (m->aa - m->bb);
    return 0.5 * (m->aa + m->bb) + sqrt(half * half + m->ab * m->ab);
}

void plant_windings_init(plant_windings_t *windings, double resistance_ohm,
                         const double shorted[PLANT_LEGS], const double contact_ohm[PLANT_LEGS])
{
    double turns[PLANT_LEGS];
    double ohm[PLANT_LEGS];
    bool are_alike = true;
    for (int k = 0; k < PLANT_LEGS; k++) {
        turns[k] = 1.0 - shorted[k];
        ohm[k] = resistance_ohm * turns[k] + contact_ohm[k];
        are_alike = are_alike && !(shorted[k] > 0.0) && !(contact_ohm[k] > 0.0);
    }
    const plant_symmetric_t e = of_phases(ohm);
    windings->are_alike = are_alike;
    windings->linkage = of_phases(turns);
    windings->inverse = inverse_of(&windings->linkage);
    windings->resistance = on_both_sides(&windings->inverse, &e);
    const double gain = largest_eigenvalue(&windings->inverse);
    windings->compliance = are_alike ? 1.0 : gain * gain;
    windings->resistance_max_ohm =
        are_alike ? resistance_ohm : largest_eigenvalue(&windings->resistance);
}
