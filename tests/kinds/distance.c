/* Distances between two triangle meshes, for the campaign by kinds. Shares no code with lodc.

The largest distance of a surface from another one is found by branch and bound: pieces of triangles
are halved, those of the largest upper bound first, until no piece can be farther than `tolerance`
times what was found. The mean of squared distances is sampled by area in strata: every triangle is
one, and those whose contributions scatter most get the most points (Neyman 1934), until the
standard error is small enough. Built by `cc -O2 -shared`, called by distance.py. */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double x, y, z;
} Point;
typedef struct {
    Point low, high;
    int32_t first, count;
} Node; /* count 0: children at first, first + 1 */
typedef struct {
    Point a, b, c;
} Triangle;
/* A piece of a triangle, by number: leaves hold pieces, as long triangles across the axes have
 * large boxes. */
typedef struct {
    Triangle piece;
    int32_t whole;
} Part;
typedef struct {
    int32_t nodes;
    Triangle *triangle;
    Part *part;
    Node *node;
} Tree;

static Point sub(Point a, Point b) { return (Point){a.x - b.x, a.y - b.y, a.z - b.z}; }
static Point along(Point a, Point d, double t) {
    return (Point){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}
static Point middle(Point a, Point b) {
    return (Point){(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
}
static double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Point cross(Point a, Point b) {
    return (Point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static double square(Point a, Point b) {
    Point d = sub(a, b);
    return dot(d, d);
}
static double axis(Point p, int k) { return k == 0 ? p.x : k == 1 ? p.y : p.z; }
static Point lower(Point a, Point b) {
    return (Point){fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)};
}
static Point upper(Point a, Point b) {
    return (Point){fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)};
}

/* Squared distance of a point from a segment. */
static double from_segment(Point p, Point a, Point b) {
    Point d = sub(b, a);
    double length = dot(d, d), t = length > 0 ? dot(sub(p, a), d) / length : 0;
    return square(p, along(a, d, t < 0 ? 0 : t > 1 ? 1 : t));
}

/* Squared distance of a point from a triangle, of any shape: inside the prism over it the distance
from its plane, else that from the nearest edge. */
static double from_triangle(Point p, const Triangle *t) {
    Point u = sub(t->b, t->a), v = sub(t->c, t->b), w = sub(t->a, t->c), n = cross(u, v);
    double nn = dot(n, n);
    if (nn > 0) {
        int su = dot(cross(u, n), sub(p, t->a)) <= 0;
        int sv = dot(cross(v, n), sub(p, t->b)) <= 0;
        int sw = dot(cross(w, n), sub(p, t->c)) <= 0;
        if (su && sv && sw) {
            double h = dot(n, sub(p, t->a));
            return h * h / nn;
        }
    }
    double d = from_segment(p, t->a, t->b);
    d = fmin(d, from_segment(p, t->b, t->c));
    return fmin(d, from_segment(p, t->c, t->a));
}

static double from_box(Point p, const Node *b) {
    double x = fmax(fmax(b->low.x - p.x, p.x - b->high.x), 0);
    double y = fmax(fmax(b->low.y - p.y, p.y - b->high.y), 0);
    double z = fmax(fmax(b->low.z - p.z, p.z - b->high.z), 0);
    return x * x + y * y + z * z;
}

static double half_area(Point low, Point high) {
    Point d = sub(high, low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static void bounds(const Triangle *t, Point *low, Point *high) {
    *low = lower(lower(t->a, t->b), t->c);
    *high = upper(upper(t->a, t->b), t->c);
}

#define BINS 16
#define LEAF 4

/* Splits triangles by the surface area heuristic over 16 bins of their boxes' middles. */
static void divide(Tree *tree, int32_t at, int depth) {
    Node *node = &tree->node[at];
    Part *t = tree->part + node->first;
    int32_t n = node->count;
    Point low = {DBL_MAX, DBL_MAX, DBL_MAX}, high = {-DBL_MAX, -DBL_MAX, -DBL_MAX}, mlow = low,
          mhigh = high;
    for (int32_t i = 0; i < n; i++) {
        Point l, h;
        bounds(&t[i].piece, &l, &h);
        low = lower(low, l), high = upper(high, h);
        mlow = lower(mlow, middle(l, h)), mhigh = upper(mhigh, middle(l, h));
    }
    node->low = low, node->high = high;
    if (n <= LEAF || depth > 60)
        return;
    double best = DBL_MAX;
    int best_axis = -1, best_bin = 0;
    for (int k = 0; k < 3; k++) {
        double from = axis(mlow, k), width = axis(mhigh, k) - from;
        if (!(width > 0))
            continue;
        int32_t count[BINS] = {0};
        Point l[BINS], h[BINS];
        for (int b = 0; b < BINS; b++)
            l[b] = (Point){DBL_MAX, DBL_MAX, DBL_MAX}, h[b] = (Point){-DBL_MAX, -DBL_MAX, -DBL_MAX};
        for (int32_t i = 0; i < n; i++) {
            Point a, z;
            bounds(&t[i].piece, &a, &z);
            int b = (int)(BINS * (axis(middle(a, z), k) - from) / width);
            b = b < BINS ? b : BINS - 1;
            count[b]++, l[b] = lower(l[b], a), h[b] = upper(h[b], z);
        }
        double right[BINS];
        int32_t behind = 0;
        Point rl = {DBL_MAX, DBL_MAX, DBL_MAX}, rh = {-DBL_MAX, -DBL_MAX, -DBL_MAX}, ll = rl,
              lh = rh;
        for (int b = BINS - 1; b > 0; b--) {
            behind += count[b], rl = lower(rl, l[b]), rh = upper(rh, h[b]);
            right[b] = behind ? behind * half_area(rl, rh) : 0;
        }
        int32_t before = 0;
        for (int b = 0; b < BINS - 1; b++) {
            before += count[b], ll = lower(ll, l[b]), lh = upper(lh, h[b]);
            if (!before || before == n)
                continue;
            double cost = before * half_area(ll, lh) + right[b + 1];
            if (cost < best)
                best = cost, best_axis = k, best_bin = b;
        }
    }
    if (best_axis < 0)
        return; /* all in one place: a large leaf */
    int32_t i = 0, j = n;
    double from = axis(mlow, best_axis), width = axis(mhigh, best_axis) - from;
    while (i < j) {
        Point a, z;
        bounds(&t[i].piece, &a, &z);
        int b = (int)(BINS * (axis(middle(a, z), best_axis) - from) / width);
        b = b < BINS ? b : BINS - 1;
        if (b <= best_bin)
            i++;
        else {
            Part moved = t[i];
            t[i] = t[--j];
            t[j] = moved;
        }
    }
    int32_t child = tree->nodes, first = node->first;
    tree->nodes += 2;
    node->first = child, node->count = 0;
    tree->node[child] = (Node){.first = first, .count = i};
    tree->node[child + 1] = (Node){.first = first + i, .count = n - i};
    divide(tree, child, depth + 1);
    divide(tree, child + 1, depth + 1);
}

static double wasted(const Triangle *t) {
    Point low, high, n = cross(sub(t->b, t->a), sub(t->c, t->a));
    bounds(t, &low, &high);
    double box = half_area(low, high);
    return box > 6 * sqrt(dot(n, n)) ? box : 0;
}

static int by_waste(const void *a, const void *b) {
    double x = wasted(&((const Part *)a)->piece), y = wasted(&((const Part *)b)->piece);
    return (x < y) - (x > y);
}

/* Cuts the parts whose boxes are largest beside what is in them in halves, up to 32 for each
 * triangle of small meshes. */
static int32_t cut(Tree *tree, int32_t n, int32_t room) {
    int32_t count = n;
    for (int round = 0; round < 12 && count < room; round++) {
        qsort(tree->part, count, sizeof(Part), by_waste);
        int32_t end = count;
        for (int32_t i = 0; i < end && count < room && wasted(&tree->part[i].piece) > 0; i++) {
            Triangle t = tree->part[i].piece;
            double ab = square(t.a, t.b), bc = square(t.b, t.c), ca = square(t.c, t.a);
            /* The longest edge becomes ab. */
            if (bc >= ab && bc >= ca)
                t = (Triangle){t.b, t.c, t.a};
            else if (ca > ab)
                t = (Triangle){t.c, t.a, t.b};
            Point m = middle(t.a, t.b);
            tree->part[i].piece = (Triangle){t.a, m, t.c};
            tree->part[count++] = (Part){{m, t.b, t.c}, tree->part[i].whole};
        }
        if (count == end)
            break;
    }
    return count;
}

/* A tree over n > 0 triangles of 9 numbers each. */
Tree *tree_new(const double *corners, int32_t n) {
    Tree *tree = malloc(sizeof *tree);
    tree->nodes = 1;
    tree->triangle = malloc(n * sizeof(Triangle));
    memcpy(tree->triangle, corners, n * sizeof(Triangle));
    int32_t room = n + (n < 12000 ? 31 * n : 372000);
    tree->part = malloc(room * sizeof(Part));
    for (int32_t i = 0; i < n; i++)
        tree->part[i] = (Part){tree->triangle[i], i};
    int32_t parts = cut(tree, n, room);
    tree->node = malloc((2 * (size_t)parts + 1) * sizeof(Node));
    tree->node[0] = (Node){.first = 0, .count = parts};
    divide(tree, 0, 0);
    return tree;
}

void tree_free(Tree *tree) { free(tree->triangle), free(tree->part), free(tree->node), free(tree); }

/* Squared distance of a point from the nearest triangle; `nearest` names one to begin with, and
 * then it. */
static double search(const Tree *tree, Point p, int32_t *nearest) {
    double best = from_triangle(p, &tree->triangle[*nearest]);
    int32_t stack[128];
    int depth = 0;
    stack[depth++] = 0;
    while (depth) {
        const Node *node = &tree->node[stack[--depth]];
        if (from_box(p, node) >= best)
            continue;
        if (node->count) {
            for (int32_t i = node->first; i < node->first + node->count; i++) {
                int32_t whole = tree->part[i].whole;
                double d = from_triangle(p, &tree->triangle[whole]);
                if (d < best)
                    best = d, *nearest = whole;
            }
            continue;
        }
        int32_t near = node->first, far = node->first + 1;
        if (from_box(p, &tree->node[near]) > from_box(p, &tree->node[far]))
            near++, far--;
        stack[depth++] = far, stack[depth++] = near;
    }
    return best;
}

/* Distances of n points of 3 numbers. */
void distances(const Tree *tree, const double *points, int32_t n, double *found) {
    int32_t nearest = 0;
    for (int32_t i = 0; i < n; i++)
        found[i] = sqrt(
            search(tree, (Point){points[3 * i], points[3 * i + 1], points[3 * i + 2]}, &nearest));
}

/* A piece of a triangle, what its corners are nearest to, and what none of its points is farther
 * than, squared. */
typedef struct {
    Point p[3];
    double d[3], bound;
    int32_t nearest[3], depth;
} Piece;
typedef struct {
    Piece *piece;
    size_t count, room;
} Heap;

static void push(Heap *heap, Piece piece) {
    if (heap->count == heap->room)
        heap->room = 2 * heap->room + 64,
        heap->piece = realloc(heap->piece, heap->room * sizeof(Piece));
    size_t at = heap->count++;
    for (; at && heap->piece[(at - 1) / 2].bound < piece.bound; at = (at - 1) / 2)
        heap->piece[at] = heap->piece[(at - 1) / 2];
    heap->piece[at] = piece;
}

static Piece pop(Heap *heap) {
    Piece top = heap->piece[0], last = heap->piece[--heap->count];
    size_t at = 0, child;
    while ((child = 2 * at + 1) < heap->count) {
        if (child + 1 < heap->count && heap->piece[child + 1].bound > heap->piece[child].bound)
            child++;
        if (heap->piece[child].bound <= last.bound)
            break;
        heap->piece[at] = heap->piece[child], at = child;
    }
    heap->piece[at] = last;
    return top;
}

/* Bounds a piece: the distance from one triangle is convex, so no point is farther from the surface
than the farthest corner is from that triangle; nor farther than the middle is, and the corner
farthest from the middle. */
static void bound(const Tree *tree, Piece *piece, double *found) {
    for (int k = 0; k < 3; k++)
        *found = fmax(*found, piece->d[k]);
    for (int k = 0; k < 3; k++) {
        if (k && (piece->nearest[k] == piece->nearest[0] ||
                  (k == 2 && piece->nearest[2] == piece->nearest[1])))
            continue;
        double most = 0;
        for (int i = 0; i < 3; i++)
            most = fmax(most, from_triangle(piece->p[i], &tree->triangle[piece->nearest[k]]));
        piece->bound = fmin(piece->bound, most);
    }
    /* What stays open is looked at from the middle, too. */
    if (piece->bound <= *found * 1.0201)
        return;
    Point sum = along(along(piece->p[0], piece->p[1], 1), piece->p[2], 1),
          m = {sum.x / 3, sum.y / 3, sum.z / 3};
    int32_t nearest = piece->nearest[0];
    double d = search(tree, m, &nearest), most = 0, reach = 0;
    *found = fmax(*found, d);
    for (int i = 0; i < 3; i++) {
        most = fmax(most, from_triangle(piece->p[i], &tree->triangle[nearest]));
        reach = fmax(reach, square(piece->p[i], m));
    }
    double simple = sqrt(d) + sqrt(reach);
    piece->bound = fmin(piece->bound, fmin(most, simple * simple));
}

/* Where the longest edge of a piece that leads from what one triangle is nearest to to what another
one is, passes from one to the other: cut there, each side has a triangle of its own to be measured
from. */
static void border(const Tree *tree, const Piece *piece, int *edge, Point *cut) {
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        int o = (k + 1) % 3;
        Point from = piece->p[k], way = sub(piece->p[o], from);
        const Triangle *a = &tree->triangle[piece->nearest[k]],
                       *b = &tree->triangle[piece->nearest[o]];
        double low = 0, high = 1;
        if (a == b || dot(way, way) <= longest)
            continue;
        if (from_triangle(from, b) <= piece->d[k] * 1.0001 ||
            from_triangle(piece->p[o], a) <= piece->d[o] * 1.0001)
            continue;
        for (int round = 0; round < 18; round++) {
            double t = (low + high) / 2;
            Point p = along(from, way, t);
            if (from_triangle(p, a) < from_triangle(p, b))
                low = t;
            else
                high = t;
        }
        longest = dot(way, way), *edge = k, *cut = along(from, way, (low + high) / 2);
    }
}

/* The largest distance of n triangles from a surface: at least low, at most high, which is within
`tolerance` times low unless `most` pieces were looked at. What is below the low that is given does
not matter. Returns the number of pieces. */
int64_t farthest(const Tree *tree, const double *corners, int32_t n, double tolerance, int64_t most,
                 double *low, double *high) {
    Heap heap = {0};
    double found = *low * *low, ratio = tolerance * tolerance;
    int64_t seen = n;
    int32_t nearest = 0;
    const Triangle *t = (const Triangle *)corners;
    Piece *first = malloc((n > 0 ? n : 1) * sizeof(Piece));
    for (int32_t i = 0; i < n; i++) {
        Piece piece = {.p = {t[i].a, t[i].b, t[i].c}, .bound = DBL_MAX};
        for (int k = 0; k < 3; k++) {
            piece.d[k] = search(tree, piece.p[k], &nearest);
            piece.nearest[k] = nearest;
            found = fmax(found, piece.d[k]);
        }
        first[i] = piece;
    }
    for (int32_t i = 0; i < n; i++) {
        bound(tree, &first[i], &found);
        if (first[i].bound > found * ratio)
            push(&heap, first[i]);
    }
    free(first);
    /* Surfaces that lie on each other end without a ratio: less is spent on them. */
    double nothing = square(tree->node[0].low, tree->node[0].high) * 1e-20;
    while (heap.count && heap.piece[0].bound > found * ratio &&
           seen < (found > nothing ? most : most / 16)) {
        Piece piece = pop(&heap);
        int longest = 0;
        for (int k = 1; k < 3; k++)
            if (square(piece.p[k], piece.p[(k + 1) % 3]) >
                square(piece.p[longest], piece.p[(longest + 1) % 3]))
                longest = k;
        Point m = middle(piece.p[longest], piece.p[(longest + 1) % 3]);
        if (piece.depth++ % 16 != 15)
            border(tree, &piece, &longest, &m);
        int other = (longest + 1) % 3;
        nearest = piece.nearest[longest];
        double d = search(tree, m, &nearest);
        Piece left = piece, right = piece;
        left.p[other] = m, left.d[other] = d, left.nearest[other] = nearest;
        right.p[longest] = m, right.d[longest] = d, right.nearest[longest] = nearest;
        bound(tree, &left, &found);
        bound(tree, &right, &found);
        if (left.bound > found * ratio)
            push(&heap, left);
        if (right.bound > found * ratio)
            push(&heap, right);
        seen += 2;
    }
    *low = sqrt(found);
    /* Pieces within the tolerance were dropped. */
    *high = sqrt(fmax(found * ratio, heap.count ? heap.piece[0].bound : 0));
    free(heap.piece);
    return seen;
}

static uint64_t scrambled(uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* Point number k of triangle i: an additive sequence in two dimensions (Roberts 2018), shifted at
 * random. */
static Point sample(const Triangle *t, uint64_t seed, uint64_t i, uint64_t k) {
    double u = (scrambled(seed ^ 2 * i) >> 11) * 0x1p-53 + 0.7548776662466927 * k;
    double v = (scrambled(seed ^ (2 * i + 1)) >> 11) * 0x1p-53 + 0.5698402909980532 * k;
    u -= floor(u), v -= floor(v);
    if (u + v > 1)
        u = 1 - u, v = 1 - v;
    return along(along(t->a, sub(t->b, t->a), u), sub(t->c, t->a), v);
}

/* The integral of the squared distance over n triangles, and its standard error. */
double integral(const Tree *tree, const double *corners, int32_t n, double wanted, int64_t most,
                uint64_t seed, double *error) {
    const Triangle *t = (const Triangle *)corners;
    double *area = malloc(n * sizeof *area), *sum = calloc(n, sizeof *sum),
           *squares = calloc(n, sizeof *squares), whole = 0, value = 0;
    int64_t *count = calloc(n, sizeof *count), taken = 0;
    int32_t nearest = 0;
    for (int32_t i = 0; i < n; i++) {
        Point normal = cross(sub(t[i].b, t[i].a), sub(t[i].c, t[i].a));
        whole += area[i] = sqrt(dot(normal, normal)) / 2;
    }
    int64_t more = 0;
    double shares = 0;
    *error = 0;
    for (int round = 0; whole > 0; round++) {
        for (int32_t i = 0; i < n; i++) {
            int64_t points = 4 + (int64_t)(10000 * area[i] / whole);
            if (round) {
                double mean = sum[i] / count[i],
                       scatter = sqrt(fmax(squares[i] / count[i] - mean * mean, 0));
                points = (int64_t)(more * area[i] * scatter / shares + 0.5);
            }
            for (int64_t end = count[i] + points; count[i] < end; count[i]++, taken++) {
                double d = search(tree, sample(&t[i], seed, i, count[i]), &nearest);
                sum[i] += d, squares[i] += d * d;
            }
        }
        double variance = 0;
        value = shares = 0;
        for (int32_t i = 0; i < n; i++) {
            double mean = sum[i] / count[i], scatter = fmax(squares[i] / count[i] - mean * mean, 0);
            value += area[i] * mean;
            shares += area[i] * sqrt(scatter);
            variance += area[i] * area[i] * scatter / count[i];
        }
        *error = sqrt(variance);
        if (*error <= wanted * value || taken >= most)
            break;
        more = taken;
    }
    free(area), free(sum), free(squares), free(count);
    return value;
}
