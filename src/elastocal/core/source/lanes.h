/* Lanes: LANES numbers side by side, and the functions of them that the core needs.
 *
 * One quantity of LANES independent problems is one value of the type `lanes`. Whatever is
 * computed of one lane does not depend on the others, so results do not depend on which problems
 * are put side by side.
 */
#ifndef ELASTOCAL_LANES_H
#define ELASTOCAL_LANES_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif

#ifndef LANES
#define LANES 2
#endif

typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef int64_t mask __attribute__((vector_size(8 * LANES)));

#define INLINE static inline __attribute__((always_inline))

INLINE lanes every(double value) { return value + (lanes){0}; }

/* Where `which` a, elsewhere b. */
INLINE lanes pick(mask which, lanes a, lanes b) {
    return (lanes)((which & (mask)a) | (~which & (mask)b));
}

INLINE int any(mask which) {
#if LANES == 4 && defined(__AVX__)
    return _mm256_movemask_pd((__m256d)which) != 0;
#elif LANES == 2 && defined(__SSE2__)
    return _mm_movemask_pd((__m128d)which) != 0;
#else
    int64_t found = 0;
    for (int i = 0; i < LANES; i++) found |= which[i];
    return found != 0;
#endif
}

INLINE lanes root(lanes a) {
#if LANES == 4 && defined(__AVX__)
    return (lanes)_mm256_sqrt_pd((__m256d)a);
#elif LANES == 2 && defined(__SSE2__)
    return (lanes)_mm_sqrt_pd((__m128d)a);
#else
    for (int i = 0; i < LANES; i++) a[i] = sqrt(a[i]);
    return a;
#endif
}

INLINE lanes larger(lanes a, lanes b) { return pick(a > b, a, b); }
INLINE lanes smaller(lanes a, lanes b) { return pick(a < b, a, b); }
INLINE lanes between(lanes a, lanes low, lanes high) { return smaller(larger(a, low), high); }
INLINE lanes size_of(lanes a) { return (lanes)((mask)a & INT64_MAX); }
INLINE lanes signed_as(lanes a, lanes sign) {
    return (lanes)((mask)size_of(a) | ((mask)sign & INT64_MIN));
}
INLINE lanes sign_of(lanes a) { return pick(a == 0.0, a, signed_as(every(1.0), a)); }
INLINE mask is_finite(lanes a) { return size_of(a) < INFINITY; }

/* Sine and cosine.
 *
 * Source: reduction to a quarter turn with π/2 in three parts of which two have 33 bits (Cody and
 * Waite), then Taylor's series, whose rest on [-π/4, π/4] is below half a rounding error.
 */
INLINE void sine_cosine(lanes x, lanes *sine, lanes *cosine) {
    if (any(size_of(x) > 1e5)) { /* beyond, the parts of π/2 no longer do */
        for (int i = 0; i < LANES; i++) {
            (*sine)[i] = sin(x[i]);
            (*cosine)[i] = cos(x[i]);
        }
        return;
    }
    const double magic = 0x1.8p52; /* added, it rounds to whole numbers */
    lanes shifted = x * 0x1.45f306dc9c883p-1 + magic;
    mask turns = (mask)shifted;
    lanes n = shifted - magic;
    lanes r = x - n * 0x1.921fb54400000p+0;
    r -= n * 0x1.0b4611a600000p-34;
    r -= n * 0x1.3198a2e037073p-69;
    lanes z = r * r;
    lanes s = z * (-1.0 / 1307674368000.0) + 1.0 / 6227020800.0;
    s = z * s - 1.0 / 39916800.0;
    s = z * s + 1.0 / 362880.0;
    s = z * s - 1.0 / 5040.0;
    s = z * s + 1.0 / 120.0;
    s = z * s - 1.0 / 6.0;
    s = r + r * (z * s);
    lanes c = z * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0;
    c = z * c + 1.0 / 479001600.0;
    c = z * c - 1.0 / 3628800.0;
    c = z * c + 1.0 / 40320.0;
    c = z * c - 1.0 / 720.0;
    c = z * c + 1.0 / 24.0;
    c = 1.0 - (0.5 * z - z * z * c);
    mask odd = (turns & 1) != 0;
    lanes first = pick(odd, c, s), second = pick(odd, s, c);
    *sine = (lanes)((mask)first ^ ((turns & 2) << 62));
    *cosine = (lanes)((mask)second ^ (((turns + 1) & 2) << 62));
}

/* Angle of (x, y) from the x axis, in [-π, π].
 *
 * Source: reduced to the tangent of at most π/8; there a polynomial of ours through Chebyshev's
 * points, good to 3e-18.
 */
INLINE lanes angle(lanes y, lanes x) {
    static const double fit[] = {
        -0.01780477396050943, 0.03796469507021349, -0.05035080589113427, 0.05846873503411509,
        -0.06662951162727927, 0.07692045274291998, -0.09090896805912162, 0.11111110744810647,
        -0.14285714279248055, 0.19999999999940868, -0.3333333333333312,
    };
    lanes wide = size_of(x), high = size_of(y);
    mask steep = high > wide;
    lanes low = pick(steep, wide, high), top = pick(steep, high, wide);
    mask far = low > 0.41421356237309503 * top;
    lanes above = pick(far, low - top, low), below = pick(far, low + top, top);
    lanes t = above / pick(below > 0.0, below, every(1.0));
    lanes z = t * t, p = every(fit[0]);
    for (int i = 1; i < 11; i++) p = p * z + fit[i];
    lanes a = pick(far, every(0x1.921fb54442d18p-1), every(0.0)) + (t + t * (z * p));
    a = pick(steep, 0x1.921fb54442d18p+0 - a, a);
    a = pick((mask)x < 0, 0x1.921fb54442d18p+1 - a, a);
    return signed_as(a, y);
}

/* Arc cosine and arc sine of what is in [-1, 1]. */
INLINE lanes arc_cosine(lanes c) { return angle(root((1.0 - c) * (1.0 + c)), c); }
INLINE lanes arc_sine(lanes s) { return angle(s, root((1.0 - s) * (1.0 + s))); }

/* Vectors of space. */
typedef struct {
    lanes x, y, z;
} vector;

INLINE vector constant(const double *v) {
    return (vector){every(v[0]), every(v[1]), every(v[2])};
}
INLINE vector plus(vector a, vector b) { return (vector){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINE vector minus(vector a, vector b) { return (vector){a.x - b.x, a.y - b.y, a.z - b.z}; }
INLINE vector times(lanes s, vector a) { return (vector){s * a.x, s * a.y, s * a.z}; }
INLINE lanes dot(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
INLINE vector cross(vector a, vector b) {
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
INLINE vector pick_vector(mask which, vector a, vector b) {
    return (vector){pick(which, a.x, b.x), pick(which, a.y, b.y), pick(which, a.z, b.z)};
}

/* A frame, and what is fixed to it. */
typedef struct {
    vector x, y, z, o;
} frame;

INLINE vector turned(const frame *f, const double *local) {
    return plus(plus(times(every(local[0]), f->x), times(every(local[1]), f->y)),
                times(every(local[2]), f->z));
}
INLINE vector carried_to(const frame *f, const double *local) {
    return plus(turned(f, local), f->o);
}

/* LANES rows of a table, `width` numbers each, side by side and back. Lanes beyond the last row
 * repeat it; they are not written. */
INLINE int64_t row_of(int64_t first, int64_t count, int lane) {
    int64_t row = first + lane;
    return row < count ? row : count - 1;
}

static inline void gather(
    lanes *to, const double *from, int64_t first, int64_t count, int64_t width
) {
    for (int i = 0; i < LANES; i++) {
        const double *row = from + row_of(first, count, i) * width;
        for (int64_t k = 0; k < width; k++) to[k][i] = row[k];
    }
}

static inline void scatter(
    double *to, const lanes *from, int64_t first, int64_t count, int64_t width
) {
    for (int i = 0; i < LANES && first + i < count; i++) {
        double *row = to + (first + i) * width;
        for (int64_t k = 0; k < width; k++) row[k] = from[k][i];
    }
}

/* Memory for so many lanes, aligned to them; `*block` is to be freed. */
static inline lanes *aligned(int64_t count, void **block) {
    *block = malloc((size_t)(count + 2) * sizeof(lanes));
    if (!*block) return 0;
    uintptr_t address = (uintptr_t)*block + sizeof(lanes) - 1;
    return (lanes *)(address - address % sizeof(lanes));
}

#endif
