/* Loads of free direction, or within a cone: bounds of the largest eigenvalue of a form.
 *
 * Q(h) = P(h)'P(h), k x k, is quadratic in h but for 2 b1 b2 + b2^2. Turned by the eigenvectors of
 * Q(0) it is [a b'; b C]; where C < T it is enough that a + |b|^2 / (T - c) <= T (Schur). In a cone
 * of half angle alpha about u the form Q + m (u u' - cos^2 alpha I) with any m >= 0 bounds as well.
 * Source: ours; docs/math.md. Included by box_bounds.h.
 */
#ifndef ELASTOCAL_FREE_LOADS_H
#define ELASTOCAL_FREE_LOADS_H

#define FORM (MOST_FORMS * (MOST_FORMS + 1) / 2)

/* Symmetric k x k, packed as pair_of. */
typedef struct {
    lanes at[FORM];
} form;

INLINE lanes trace_of(int64_t k, const form *a) {
    lanes sum = every(0.0);
    for (int64_t i = 0; i < k; i++) sum += a->at[pair_of(i, i)];
    return sum;
}

INLINE lanes entry(const form *a, int64_t i, int64_t j) {
    return a->at[i <= j ? pair_of(i, j) : pair_of(j, i)];
}

/* At least the largest eigenvalue of a form that is not negative: (tr S^4)^(1/4). */
INLINE lanes at_least_largest(int64_t k, const form *a) {
    lanes sum = every(0.0);
    for (int64_t i = 0; i < k; i++)
        for (int64_t j = 0; j < k; j++) {
            lanes square = every(0.0);
            for (int64_t l = 0; l < k; l++) square += entry(a, i, l) * entry(a, l, j);
            sum += square * square;
        }
    return root(root(sum));
}

/* Turns a into its eigenvectors' frame, nearly, by sweeps of Jacobi; `e` are the columns. */
INLINE void turn_to_axes(int64_t k, int sweeps, form *a, lanes (*e)[MOST_FORMS]) {
    for (int64_t i = 0; i < k; i++)
        for (int64_t j = 0; j < k; j++) e[i][j] = every(i == j ? 1.0 : 0.0);
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (int64_t p = 0; p < k; p++)
            for (int64_t q = p + 1; q < k; q++) {
                lanes off = entry(a, p, q), gap = entry(a, q, q) - entry(a, p, p);
                mask small = size_of(off) <= 1e-300;
                lanes ratio = 0.5 * gap / pick(small, every(1.0), off);
                lanes t = signed_as(every(1.0), ratio) /
                          (size_of(ratio) + root(1.0 + ratio * ratio));
                t = pick(small | ~is_finite(t), every(0.0), t);
                lanes c = 1.0 / root(1.0 + t * t), d = t * c;
                form b = *a;
                b.at[pair_of(p, p)] = entry(a, p, p) - t * off;
                b.at[pair_of(q, q)] = entry(a, q, q) + t * off;
                b.at[pair_of(p, q)] = pick(small, off, every(0.0));
                for (int64_t l = 0; l < k; l++) {
                    if (l == p || l == q) continue;
                    lanes first = entry(a, l, p), second = entry(a, l, q);
                    b.at[l <= p ? pair_of(l, p) : pair_of(p, l)] = c * first - d * second;
                    b.at[l <= q ? pair_of(l, q) : pair_of(q, l)] = d * first + c * second;
                }
                *a = b;
                for (int64_t l = 0; l < k; l++) {
                    lanes first = e[l][p], second = e[l][q];
                    e[l][p] = c * first - d * second;
                    e[l][q] = d * first + c * second;
                }
            }
    /* The largest first. */
    for (int64_t i = 1; i < k; i++) {
        mask swap = a->at[pair_of(i, i)] > a->at[pair_of(0, 0)];
        lanes held = a->at[pair_of(0, 0)];
        a->at[pair_of(0, 0)] = pick(swap, a->at[pair_of(i, i)], held);
        a->at[pair_of(i, i)] = pick(swap, held, a->at[pair_of(i, i)]);
        for (int64_t l = 0; l < k; l++) {
            lanes first = e[l][0];
            e[l][0] = pick(swap, e[l][i], first);
            e[l][i] = pick(swap, first, e[l][i]);
        }
    }
}

/* e' a e. */
INLINE form seen_from(int64_t k, const form *a, lanes (*e)[MOST_FORMS]) {
    lanes half[MOST_FORMS][MOST_FORMS];
    form b;
    for (int64_t i = 0; i < k; i++)
        for (int64_t j = 0; j < k; j++) {
            half[i][j] = every(0.0);
            for (int64_t l = 0; l < k; l++) half[i][j] += entry(a, i, l) * e[l][j];
        }
    for (int64_t j = 0; j < k; j++)
        for (int64_t i = 0; i <= j; i++) {
            lanes sum = every(0.0);
            for (int64_t l = 0; l < k; l++) sum += e[l][i] * half[l][j];
            b.at[pair_of(i, j)] = sum;
        }
    return b;
}

/* a_f . b_g + a_g . b_f, halved where a is b. */
INLINE form product_form(int64_t k, const vector *a, const vector *b, int64_t width) {
    form found;
    for (int64_t j = 0; j < k; j++)
        for (int64_t i = 0; i <= j; i++) {
            lanes sum = product_of(a + i * width, b + j * width, width);
            if (a != b) sum += product_of(a + j * width, b + i * width, width);
            found.at[pair_of(i, j)] = sum;
        }
    return found;
}

INLINE void add_cone(const Statement *s, lanes m, form *a) {
    const double *u = s->cone_axis;
    for (int64_t j = 0; j < 3; j++)
        for (int64_t i = 0; i <= j; i++) {
            double term = u[i] * u[j] - (i == j ? s->cone_cosine * s->cone_cosine : 0.0);
            a->at[pair_of(i, j)] += m * term;
        }
}

/* The multiplier of the cone, and the largest value in it: lambda_max is convex in m, and its slope
 * is (u . e)^2 - cos^2 alpha with its eigenvector e. */
static inline lanes cone_multiplier(const Statement *s, const form *a, lanes *value) {
    lanes low = every(0.0), high = every(0.0), e[MOST_FORMS][MOST_FORMS];
    form b = *a;
    turn_to_axes(3, 4, &b, e);
    *value = b.at[0];
    lanes cosine = s->cone_axis[0] * e[0][0] + s->cone_axis[1] * e[1][0] + s->cone_axis[2] * e[2][0];
    const double edge = s->cone_cosine * s->cone_cosine;
    mask outside = cosine * cosine < edge;
    if (!any(outside)) return low;
    high = pick(outside, trace_of(3, a) / (1.0 - edge), every(0.0));
    lanes m = high;
    for (int step = 0; step < 18; step++) {
        m = 0.5 * (low + high);
        b = *a;
        add_cone(s, m, &b);
        turn_to_axes(3, 4, &b, e);
        *value = pick(outside, smaller(*value, b.at[0]), *value);
        cosine = s->cone_axis[0] * e[0][0] + s->cone_axis[1] * e[1][0] + s->cone_axis[2] * e[2][0];
        mask rising = cosine * cosine >= edge;
        high = pick(rising, m, high);
        low = pick(rising, low, m);
    }
    return pick(outside, high, every(0.0));
}

/* The bound of a box is `aim` where it can be shown, else INFINITY. */
static void bound_free(const Statement *s, const Room *room, int64_t count, const lanes *rest,
                       const lanes *r, const lanes *inverse, lanes third, const lanes *cubic,
                       double aim, Found *found) {
    const int64_t n = s->joints, k = s->forms, pairs = n * (n + 1) / 2;
    const int64_t width = targets_of(s) * s->rank, all = row_vectors(s);
    const vector *rows = room->rows, *first = rows + all, *second = first + n * all;
    form zero = product_form(k, rows, rows, width), slope[MOST_JOINTS], bend[PAIRS];
    lanes share[MOST_JOINTS], b1 = every(0.0), b2 = every(0.0);
    for (int64_t i = 0; i < n; i++) share[i] = every(0.0);
    for (int64_t j = 0; j < n; j++) {
        slope[j] = product_form(k, rows, first + j * all, width);
        for (int64_t i = 0; i <= j; i++) {
            const int64_t at = pair_of(i, j);
            const vector *both = second + at * all;
            form across = product_form(k, first + i * all, first + j * all, width);
            if (i == j) {
                b1 += r[i] * root(at_least_largest(k, &across));
                for (int64_t c = 0; c < k * (k + 1) / 2; c++) across.at[c] *= 2.0;
            }
            bend[at] = product_form(k, rows, both, width);
            for (int64_t c = 0; c < k * (k + 1) / 2; c++) bend[at].at[c] += across.at[c];
            form own = product_form(k, both, both, width);
            lanes part = root(at_least_largest(k, &own)) * r[i] * r[j] * (i == j ? 0.5 : 1.0);
            b2 += part;
            share[i] += part;
            share[j] += part;
        }
    }
    lanes cautious = every(0.0);
    if (s->cone) {
        lanes m = cone_multiplier(s, &zero, &found->value);
        cautious = CAUTION * EPSILON * m; /* it is large for narrow cones */
        add_cone(s, m, &zero);
    }
    lanes e[MOST_FORMS][MOST_FORMS];
    form start = zero;
    turn_to_axes(k, 4, &zero, e);
    if (!s->cone) found->value = zero.at[0];
    zero = seen_from(k, &start, e); /* as it is, rounding and all */
    for (int64_t j = 0; j < n; j++) slope[j] = seen_from(k, &slope[j], e);
    for (int64_t c = 0; c < pairs; c++) bend[c] = seen_from(k, &bend[c], e);
    const lanes over = 2.0 * b1 * b2 + b2 * b2;
    lanes length = root(every(aim)) - third;
    mask possible = length > 0.0;
    lanes level = length * length - over - cautious; /* T */
    /* The largest eigenvalue of the rest. */
    lanes c = every(-INFINITY), across = every(0.0), g[MOST_JOINTS], h[PAIRS];
    for (int64_t p = 1; p < k; p++) {
        const int64_t at = pair_of(p, p);
        for (int64_t i = 0; i < n; i++) g[i] = slope[i].at[at];
        for (int64_t i = 0; i < pairs; i++) h[i] = bend[i].at[at];
        lanes own = zero.at[at] + largest_of_quadratic(n, g, h, r, inverse, 0);
        possible &= is_finite(own);
        c = larger(c, own);
    }
    if (k == 3) {
        const int64_t at = pair_of(1, 2);
        across = size_of(zero.at[at]);
        for (int64_t i = 0; i < n; i++) across += size_of(slope[i].at[at]) * r[i];
        for (int64_t j = 0; j < n; j++)
            for (int64_t i = 0; i <= j; i++)
                across += size_of(bend[pair_of(i, j)].at[at]) * r[i] * r[j] * (i == j ? 0.5 : 1.0);
        c += across;
    }
    possible &= c < level;
    lanes weight = 1.0 / pick(possible, level - c, every(INFINITY));
    Objective o;
    lanes part[MOST_JOINTS], aside1 = every(0.0), aside2 = every(0.0), square = every(0.0);
    lanes lean[MOST_JOINTS], bent;
    o.level = zero.at[0];
    for (int64_t i = 0; i < n; i++) o.slope[i] = slope[i].at[0], lean[i] = every(0.0);
    for (int64_t i = 0; i < pairs; i++) o.bend[i] = bend[i].at[0];
    for (int64_t p = 1; p < k; p++) {
        const int64_t at = pair_of(0, p);
        square += zero.at[at] * zero.at[at];
        for (int64_t j = 0; j < n; j++) {
            o.slope[j] += 2.0 * weight * zero.at[at] * slope[j].at[at];
            lean[j] += slope[j].at[at] * slope[j].at[at];
            for (int64_t i = 0; i <= j; i++)
                o.bend[pair_of(i, j)] +=
                    2.0 * weight * (slope[i].at[at] * slope[j].at[at] +
                                    zero.at[at] * bend[pair_of(i, j)].at[at]);
        }
    }
    o.level += weight * square;
    for (int64_t j = 0; j < n; j++) {
        aside1 += r[j] * root(lean[j]);
        for (int64_t i = 0; i <= j; i++) {
            bent = every(0.0);
            for (int64_t p = 1; p < k; p++) {
                lanes b = bend[pair_of(i, j)].at[pair_of(0, p)];
                bent += b * b;
            }
            aside2 += root(bent) * r[i] * r[j] * (i == j ? 0.5 : 1.0);
        }
    }
    const lanes beyond = weight * (2.0 * aside1 * aside2 + aside2 * aside2);
    o.level += beyond;
    /* Schur's inequality is one of numbers at each allowed h: so constraints add to it alone. */
    lanes most = with_conditions(s, room, count, rest, r, inverse, &o, part);
    found->bound = pick(possible & (most <= level), every(aim), every(INFINITY));
    length = root(larger(zero.at[0], every(0.0)));
    for (int64_t i = 0; i < n; i++)
        found->weight[i] = part[i] + 2.0 * (b1 + b2) * share[i] + 6.0 * length * cubic[i];
}

#endif
