/* Branch and bound over boxes, depth first, LANES boxes at a time.
 *
 * A box is halved in one variable until its bound is below the threshold. The tree comes back in
 * depth-first order, a byte a box: the variable that is halved, LEAF, OPEN where a box is as small
 * as boxes get, or PENDING where the search ended before it.
 */
#ifndef ELASTOCAL_SUBTREES_H
#define ELASTOCAL_SUBTREES_H

#include <stdlib.h>

#include "box_bounds.h"

enum { PENDING = 253, OPEN = 254, LEAF = 255 };

/* What a search found. */
typedef struct {
    int64_t evaluated;
    int64_t symbols;   /* of the tree */
    int64_t pending;   /* boxes left */
    int64_t open;      /* boxes that could not be bounded */
    double largest;    /* bound of all leaves */
    double best;       /* largest sensitivity at an allowed centre; -1 if none was met */
    double at[MOST_JOINTS];
} Outcome;

/* Half-widths are a little wider than they are: neighbours overlap. */
#define WIDER (1.0 + 1e-12)

/* Centres and half-widths of boxes in [0, 1]^n as they are in x. */
INLINE void box_in_x(const Statement *s, const lanes *center, const lanes *half, lanes *x,
                     lanes *r) {
    for (int64_t i = 0; i < s->joints; i++) {
        const double range = s->upper[i] - s->lower[i];
        const double rounding = 4.0 * EPSILON * (fabs(s->lower[i]) + fabs(s->upper[i]));
        x[i] = s->lower[i] + range * center[i];
        r[i] = range * half[i] * WIDER + 1e-14 + rounding;
    }
}

/* The variable to be halved in a lane. */
INLINE int64_t widest(const Statement *s, const Found *found, int lane) {
    int64_t best = 0;
    for (int64_t i = 1; i < s->joints; i++)
        if (found->weight[i][lane] > found->weight[best][lane]) best = i;
    return best;
}

typedef struct {
    uint8_t *symbol;
    int32_t *child;
    int64_t count, room;
} Tree;

static int grown(Tree *tree, int64_t more) {
    if (tree->count + more <= tree->room) return 1;
    int64_t room = 2 * tree->room + more;
    uint8_t *symbol = realloc(tree->symbol, (size_t)room);
    if (symbol) tree->symbol = symbol;
    int32_t *child = realloc(tree->child, (size_t)room * sizeof *child);
    if (child) tree->child = child;
    if (!symbol || !child) return 0;
    tree->room = room;
    return 1;
}

/* Searches the box (center, half) of [0, 1]^n. `boxes` (2 n, most pending) and `symbols` come
 * back; returns -1 without memory, -2 if they have no room. */
static int64_t search_box(const Statement *s, const Room *room, const double *center,
                          const double *half, double threshold, double smallest, int64_t most,
                          uint8_t *symbols, int64_t symbol_room, double *boxes, int64_t box_room,
                          Outcome *outcome) {
    const int64_t n = s->joints, wide = 2 * n;
    int64_t stack_room = 4096, stacked = 1, answer = 0;
    double *stack = malloc((size_t)(stack_room * wide + 1) * sizeof *stack);
    int32_t *nodes = malloc((size_t)stack_room * sizeof *nodes);
    Tree tree = {malloc(4096), malloc(4096 * sizeof(int32_t)), 1, 4096};
    memset(outcome, 0, sizeof *outcome);
    outcome->best = -1.0;
    if (!stack || !nodes || !tree.symbol || !tree.child) answer = -1;
    if (!answer) {
        memcpy(stack, center, (size_t)n * sizeof *stack);
        memcpy(stack + n, half, (size_t)n * sizeof *stack);
        nodes[0] = 0;
        tree.symbol[0] = PENDING;
    }
    lanes u[MOST_JOINTS], w[MOST_JOINTS], x[MOST_JOINTS], r[MOST_JOINTS];
    Found found;
    while (!answer && stacked && outcome->evaluated < most) {
        const int64_t now = stacked < LANES ? stacked : LANES;
        stacked -= now;
        double *top = stack + stacked * wide;
        double own[LANES * 2 * MOST_JOINTS];
        int32_t node[LANES];
        memcpy(own, top, (size_t)(now * wide) * sizeof *own);
        memcpy(node, nodes + stacked, (size_t)now * sizeof *node);
        for (int l = 0; l < LANES; l++)
            for (int64_t i = 0; i < n; i++) {
                const double *box = own + (l < now ? l : now - 1) * wide;
                u[i][l] = box[i];
                w[i][l] = box[n + i];
            }
        box_in_x(s, u, w, x, r);
        bound_boxes(s, room, x, r, threshold, &found);
        outcome->evaluated += now;
        for (int l = 0; l < now; l++) {
            if (found.empty[l]) {
                tree.symbol[node[l]] = LEAF;
                continue;
            }
            if (found.inside[l] && found.value[l] > outcome->best) {
                outcome->best = found.value[l];
                for (int64_t i = 0; i < n; i++) outcome->at[i] = x[i][l];
            }
            if (found.bound[l] <= threshold) {
                if (found.bound[l] > outcome->largest) outcome->largest = found.bound[l];
                tree.symbol[node[l]] = LEAF;
                continue;
            }
            const int64_t k = widest(s, &found, l);
            double *box = own + l * wide;
            if (!n || (s->upper[k] - s->lower[k]) * box[n + k] < smallest) {
                if (!(found.bound[l] <= outcome->largest)) outcome->largest = found.bound[l];
                tree.symbol[node[l]] = OPEN;
                outcome->open++;
                continue;
            }
            if (!grown(&tree, 2)) {
                answer = -1;
                break;
            }
            if (stacked + 2 + LANES > stack_room) {
                stack_room *= 2;
                double *larger_stack = realloc(stack, (size_t)(stack_room * wide) * sizeof *stack);
                if (larger_stack) stack = larger_stack;
                int32_t *more = realloc(nodes, (size_t)stack_room * sizeof *nodes);
                if (more) nodes = more;
                if (!larger_stack || !more) {
                    answer = -1;
                    break;
                }
            }
            tree.symbol[node[l]] = (uint8_t)k;
            tree.child[node[l]] = (int32_t)tree.count;
            box[n + k] *= 0.5;
            for (int side = 1; side >= 0; side--) { /* the lower half on top */
                double *to = stack + stacked * wide;
                memcpy(to, box, (size_t)wide * sizeof *to);
                to[k] += side ? box[n + k] : -box[n + k];
                nodes[stacked++] = (int32_t)tree.count + side;
                tree.symbol[tree.count + side] = PENDING;
            }
            tree.count += 2;
        }
    }
    /* Depth first, the children of a node side by side; pending boxes in the same order. */
    outcome->pending = stacked;
    outcome->symbols = tree.count;
    if (!answer && (tree.count > symbol_room || stacked > box_room)) answer = -2;
    int32_t *way = answer ? 0 : malloc((size_t)(tree.count + 1) * sizeof *way);
    int32_t *place = answer ? 0 : malloc((size_t)(tree.count + 1) * sizeof *place);
    if (!answer && (!way || !place)) answer = -1;
    if (!answer) {
        for (int64_t k = 0; k < stacked; k++) place[nodes[k]] = (int32_t)k;
        int64_t on = 1, written = 0, left = 0;
        way[0] = 0;
        while (on) {
            const int32_t node = way[--on];
            const uint8_t symbol = tree.symbol[node];
            symbols[written++] = symbol;
            if (symbol == PENDING)
                memcpy(boxes + wide * left++, stack + place[node] * wide,
                       (size_t)wide * sizeof *boxes);
            if (symbol < PENDING) {
                way[on++] = tree.child[node] + 1;
                way[on++] = tree.child[node];
            }
        }
    }
    free(way);
    free(place);
    free(stack);
    free(nodes);
    free(tree.symbol);
    free(tree.child);
    return answer;
}

/* The box [center ± half] of the leaf that a point of [0, 1]^n is in; the number of its symbol, or
 * -1 if the tree ends before. */
static int64_t find_leaf(int64_t n, const uint8_t *symbols, int64_t count, const double *point,
                         double *center, double *half) {
    for (int64_t at = 0; at < count; at++) {
        const int64_t k = symbols[at];
        if (k >= PENDING) return at;
        if (k >= n) return -1;
        half[k] *= 0.5;
        if (point[k] <= center[k]) {
            center[k] -= half[k];
            continue;
        }
        center[k] += half[k];
        for (int64_t open = 1; open && at + 1 < count; at++)
            open += symbols[at + 1] < PENDING ? 1 : -1;
    }
    return -1;
}

#endif
