"""C that headers share, with @ for the name and @@ for the name in capitals."""

CHEBYSHEV_SUM = """\
static inline double @_sum_(const double *terms, double u)
{
    double last = 0.0, before = 0.0;
    int j;
    for (j = @@_TERMS - 1; j > 0; --j) {
        const double next = terms[j] + 2.0 * u * last - before;
        before = last;
        last = next;
    }
    return terms[0] + u * last - before;
}
"""
"""A Chebyshev series at u from -1 to 1 (Clenshaw 1955)."""
