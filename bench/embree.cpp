// Rays a second of Embree 3 on one core, for bench/embree.py: a file of the example `triangles` (what is in it stands there) as triangles and as
// spheres. Prints lines of: kind, rays, million rays a second of processor time, the part that hits.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <vector>

#include <embree3/rtcore.h>
#include <pmmintrin.h>

// As many random rays as `superegg bench` has.
constexpr size_t RANDOM_RAYS = 1 << 17;
constexpr int PACKET = 16;

struct Ray {
    float origin[3], direction[3];
};

static double processor_seconds() {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
}

static size_t by_packets(RTCScene scene, const std::vector<Ray>& rays, RTCIntersectContextFlags flags) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = flags;
    alignas(64) int valid[PACKET];
    std::fill(valid, valid + PACKET, -1);
    size_t hits = 0;
    RTCRayHit16 packet;
    for (size_t first = 0; first + PACKET <= rays.size(); first += PACKET) {
        for (int i = 0; i < PACKET; i++) {
            const Ray& ray = rays[first + i];
            packet.ray.org_x[i] = ray.origin[0];
            packet.ray.org_y[i] = ray.origin[1];
            packet.ray.org_z[i] = ray.origin[2];
            packet.ray.dir_x[i] = ray.direction[0];
            packet.ray.dir_y[i] = ray.direction[1];
            packet.ray.dir_z[i] = ray.direction[2];
            packet.ray.tnear[i] = packet.ray.time[i] = 0;
            packet.ray.tfar[i] = 1e30f;
            packet.ray.mask[i] = ~0u;
            packet.ray.flags[i] = 0;
            packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16(valid, scene, &context, &packet);
        for (int i = 0; i < PACKET; i++) hits += packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

static size_t one_by_one(RTCScene scene, const std::vector<Ray>& rays) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    size_t hits = 0;
    for (const Ray& ray : rays) {
        RTCRayHit one;
        one.ray.org_x = ray.origin[0];
        one.ray.org_y = ray.origin[1];
        one.ray.org_z = ray.origin[2];
        one.ray.dir_x = ray.direction[0];
        one.ray.dir_y = ray.direction[1];
        one.ray.dir_z = ray.direction[2];
        one.ray.tnear = one.ray.time = 0;
        one.ray.tfar = 1e30f;
        one.ray.mask = ~0u;
        one.ray.flags = 0;
        one.hit.geomID = one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &one);
        hits += one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

template <class Work>
static void print_best(const char* kind, const char* rays, size_t count, int rounds, Work work) {
    double best = 1e30;
    size_t hits = 0;
    for (int i = 0; i < rounds; i++) {
        double before = processor_seconds();
        hits = work();
        best = std::min(best, processor_seconds() - before);
    }
    printf("%s %s %.3f %.4f\n", kind, rays, count / best / 1e6, double(hits) / count);
}

static void measure(RTCDevice device, const char* kind, RTCGeometry geometry, const std::vector<Ray>& camera,
                    const std::vector<Ray>& random, int rounds) {
    // The slowest build has the quickest rays.
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    print_best(kind, "camera", camera.size(), rounds,
               [&] { return by_packets(scene, camera, RTC_INTERSECT_CONTEXT_FLAG_COHERENT); });
    print_best(kind, "random", random.size(), rounds, [&] { return one_by_one(scene, random); });
    print_best(kind, "random", random.size(), rounds,
               [&] { return by_packets(scene, random, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT); });
    rtcReleaseScene(scene);
}

int main(int count_of_arguments, char** arguments) {
    if (count_of_arguments != 3) {
        fprintf(stderr, "usage: embree FILE ROUNDS\n");
        return 2;
    }
    // What Embree's manual asks of its users.
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    FILE* file = fopen(arguments[1], "rb");
    if (!file) {
        perror(arguments[1]);
        return 1;
    }
    auto read = [&](void* to, size_t bytes) {
        if (fread(to, 1, bytes, file) != bytes) {
            fprintf(stderr, "%s ends too early\n", arguments[1]);
            exit(1);
        }
    };
    uint64_t counts[4];
    float corners[6], eye[3];
    read(counts, sizeof counts);
    read(corners, sizeof corners);
    read(eye, sizeof eye);
    RTCDevice device = rtcNewDevice(nullptr);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    RTCGeometry balls = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    auto read_buffer = [&](RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t size, size_t count) {
        read(rtcSetNewGeometryBuffer(geometry, type, 0, format, size, count), size * count);
    };
    read_buffer(mesh, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, counts[0]);
    read_buffer(mesh, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12, counts[1]);
    read_buffer(balls, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 16, counts[2]);
    std::vector<Ray> camera(counts[3]), random(RANDOM_RAYS);
    for (Ray& ray : camera) {
        std::copy(eye, eye + 3, ray.origin);
        read(ray.direction, sizeof ray.direction);
    }
    std::mt19937 twister(1);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (Ray& ray : random) {
        for (int axis = 0; axis < 3; axis++) {
            float middle = 0.5f * (corners[axis + 3] + corners[axis]), half = 0.5f * (corners[axis + 3] - corners[axis]);
            ray.origin[axis] = middle + half * unit(twister);
        }
        float square;
        do {
            square = 0;
            for (float& coordinate : ray.direction) {
                coordinate = unit(twister);
                square += coordinate * coordinate;
            }
        } while (square < 0.01f || square > 1);
    }
    int rounds = atoi(arguments[2]);
    measure(device, "triangles", mesh, camera, random, rounds);
    measure(device, "spheres", balls, camera, random, rounds);
}
