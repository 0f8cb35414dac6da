/* Draws triangles seen from far away: a z-buffer with several samples a pixel, textures by mip maps,
   interpolated normals, two lamps. Nothing of lodc's own rasteriser is used. */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    int width, height, levels;
    float *level[16];
} Texture;

static Texture *textures;
static int texture_count;

static int at_least_one(int n) { return n > 0 ? n : 1; }

/* A level of half the size: means of 2 x 2 texels. */
static float *halved(const float *from, int width, int height) {
    int w = at_least_one(width / 2), h = at_least_one(height / 2);
    float *to = malloc(sizeof(float) * 4 * w * h);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            for (int c = 0; c < 4; c++) {
                float sum = 0;
                for (int k = 0; k < 4; k++) {
                    int u = 2 * x + (k & 1), v = 2 * y + (k >> 1);
                    u = u < width ? u : width - 1;
                    v = v < height ? v : height - 1;
                    sum += from[4 * (v * width + u) + c];
                }
                to[4 * (y * w + x) + c] = sum / 4;
            }
    return to;
}

/* Takes the images of a scene: red, green, blue and alpha in bytes. */
void take_textures(int count, const int *widths, const int *heights, const uint8_t *const *pixels) {
    for (int i = 0; i < texture_count; i++)
        for (int k = 0; k < textures[i].levels; k++) free(textures[i].level[k]);
    free(textures);
    textures = calloc(at_least_one(count), sizeof(Texture));
    texture_count = count;
    for (int i = 0; i < count; i++) {
        int w = widths[i], h = heights[i];
        Texture *t = &textures[i];
        *t = (Texture){.width = w, .height = h, .levels = 1};
        t->level[0] = malloc(sizeof(float) * 4 * w * h);
        for (int k = 0; k < 4 * w * h; k++) t->level[0][k] = pixels[i][k] / 255.0f;
        for (; (w > 1 || h > 1) && t->levels < 16; t->levels++) {
            t->level[t->levels] = halved(t->level[t->levels - 1], w, h);
            w = at_least_one(w / 2);
            h = at_least_one(h / 2);
        }
    }
}

static void between_texels(const Texture *t, int level, float u, float v, float *colour) {
    int w = at_least_one(t->width >> level), h = at_least_one(t->height >> level);
    float x = (u - floorf(u)) * w - 0.5f, y = (v - floorf(v)) * h - 0.5f;
    int left = (int)floorf(x), top = (int)floorf(y);
    float right_share = x - left, bottom_share = y - top;
    for (int c = 0; c < 4; c++) colour[c] = 0;
    for (int k = 0; k < 4; k++) {
        int column = (left + (k & 1) + w) % w, row = (top + (k >> 1) + h) % h;
        float share = (k & 1 ? right_share : 1 - right_share)
                    * (k >> 1 ? bottom_share : 1 - bottom_share);
        for (int c = 0; c < 4; c++) colour[c] += share * t->level[level][4 * (row * w + column) + c];
    }
}

static void texel(const Texture *t, float level, float u, float v, float *colour) {
    float last = t->levels - 1, finer[4], coarser[4];
    level = !(level > 0) ? 0 : level > last ? last : level;
    int below = (int)level;
    between_texels(t, below, u, v, finer);
    if (below + 1 >= t->levels) {
        memcpy(colour, finer, sizeof finer);
        return;
    }
    between_texels(t, below + 1, u, v, coarser);
    for (int c = 0; c < 4; c++) colour[c] = finer[c] + (level - below) * (coarser[c] - finer[c]);
}

static float dot(const float *a, const float *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void to_unit(float *a) {
    float length = sqrtf(dot(a, a));
    for (int k = 0; k < 3 && length > 0; k++) a[k] /= length;
}

static float smaller(float a, float b) { return a < b ? a : b; }
static float larger(float a, float b) { return a > b ? a : b; }

/* Draws `count` triangles, given by corner: positions, normals, texture coordinates, colours (4);
   by triangle a material. A material is base colour (4), texture or -1, two-sided, mode (0 opaque,
   1 mask, 2 blend) and cutoff. A camera is right, up, towards the eye, centre, radius.
   Gives colours of 0 to 255, and the share of each pixel that is covered. */
void draw(int count, const float *positions, const float *normals, const float *coordinates,
          const float *colours, const int *material_of, const float *materials,
          const float *camera, int size, int samples, float *pixels, float *covered) {
    static const float screen_door[4] = {0.125f, 0.625f, 0.875f, 0.375f};
    const float *right = camera, *up = camera + 3, *eye = camera + 6, *centre = camera + 9;
    int across = size * samples;
    float scale = 0.5f * across / camera[12], lamp[3], half[3];
    float *depth = malloc(sizeof(float) * across * across);
    float *colour = calloc((size_t)across * across * 3, sizeof(float));
    for (int i = 0; i < across * across; i++) depth[i] = -FLT_MAX;
    for (int k = 0; k < 3; k++) lamp[k] = eye[k] + 0.5f * up[k] - 0.6f * right[k];
    to_unit(lamp);
    for (int k = 0; k < 3; k++) half[k] = lamp[k] + eye[k];
    to_unit(half);
    for (int f = 0; f < count; f++) {
        float x[3], y[3], z[3];
        for (int k = 0; k < 3; k++) {
            float p[3];
            for (int c = 0; c < 3; c++) p[c] = positions[9 * (size_t)f + 3 * k + c] - centre[c];
            x[k] = 0.5f * across + scale * dot(p, right);
            y[k] = 0.5f * across - scale * dot(p, up);
            z[k] = dot(p, eye);
        }
        float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        const float *material = materials + 8 * material_of[f];
        int is_back = area > 0;
        if (area == 0 || (is_back && material[5] == 0)) continue;
        const float *uv = coordinates + 6 * (size_t)f, *shades = colours + 12 * (size_t)f;
        const Texture *texture = material[4] < 0 ? NULL : &textures[(int)material[4]];
        float level = 0;
        if (texture) {
            float texels = fabsf((uv[2] - uv[0]) * (uv[5] - uv[1]) - (uv[4] - uv[0]) * (uv[3] - uv[1]))
                         * texture->width * texture->height;
            float drawn = fabsf(area) / (samples * samples);
            level = 0.5f * log2f(larger(texels, 1e-12f) / larger(drawn, 1e-12f));
        }
        int first_x = (int)larger(0, floorf(smaller(x[0], smaller(x[1], x[2]))));
        int last_x = (int)smaller(across - 1, ceilf(larger(x[0], larger(x[1], x[2]))));
        int first_y = (int)larger(0, floorf(smaller(y[0], smaller(y[1], y[2]))));
        int last_y = (int)smaller(across - 1, ceilf(larger(y[0], larger(y[1], y[2]))));
        for (int row = first_y; row <= last_y; row++)
            for (int column = first_x; column <= last_x; column++) {
                float px = column + 0.5f, py = row + 0.5f, w[3];
                w[0] = ((x[1] - px) * (y[2] - py) - (x[2] - px) * (y[1] - py)) / area;
                w[1] = ((x[2] - px) * (y[0] - py) - (x[0] - px) * (y[2] - py)) / area;
                w[2] = 1 - w[0] - w[1];
                float near = w[0] * z[0] + w[1] * z[1] + w[2] * z[2];
                int i = row * across + column;
                if (w[0] < 0 || w[1] < 0 || w[2] < 0 || near <= depth[i]) continue;
                float base[4] = {1, 1, 1, 1}, own[4] = {1, 1, 1, 1};
                if (texture)
                    texel(texture, level, w[0] * uv[0] + w[1] * uv[2] + w[2] * uv[4],
                          w[0] * uv[1] + w[1] * uv[3] + w[2] * uv[5], own);
                for (int c = 0; c < 4; c++)
                    base[c] = own[c] * material[c]
                            * (w[0] * shades[c] + w[1] * shades[4 + c] + w[2] * shades[8 + c]);
                if (material[6] == 1 && base[3] < material[7]) continue;
                if (material[6] == 2
                    && base[3] < screen_door[(column & 1) + 2 * (row & 1)])
                    continue;
                const float *n = normals + 9 * (size_t)f;
                float normal[3];
                for (int c = 0; c < 3; c++)
                    normal[c] = (w[0] * n[c] + w[1] * n[3 + c] + w[2] * n[6 + c])
                              * (is_back ? -1 : 1);
                to_unit(normal);
                float light = 0.2f + 0.55f * larger(0, dot(normal, lamp))
                            + 0.2f * larger(0, dot(normal, eye));
                float gloss = 0.12f * powf(larger(0, dot(normal, half)), 24);
                depth[i] = near;
                for (int c = 0; c < 3; c++)
                    colour[3 * i + c] = smaller(1, larger(0, base[c]) * light + gloss);
            }
    }
    float share = 1.0f / (samples * samples);
    memset(pixels, 0, sizeof(float) * 3 * size * size);
    memset(covered, 0, sizeof(float) * size * size);
    for (int row = 0; row < across; row++)
        for (int column = 0; column < across; column++) {
            int i = row * across + column, pixel = row / samples * size + column / samples;
            if (depth[i] == -FLT_MAX) continue;
            covered[pixel] += share;
            for (int c = 0; c < 3; c++) pixels[3 * pixel + c] += 255 * share * colour[3 * i + c];
        }
    free(depth);
    free(colour);
}
