// A Vulkan layer that makes real faults of a driver: a device that is lost at a submission, memory that runs out.
//
// FAULTY_DRIVER_NOTES=FILE      takes down a '.' for each submission and a '!' for each refusal of memory
// FAULTY_DRIVER_LOST_AT=N       the N-th submission and all after it return VK_ERROR_DEVICE_LOST
// FAULTY_DRIVER_FULL_AT=N       after N submissions, every new buffer returns VK_ERROR_OUT_OF_DEVICE_MEMORY
// FAULTY_DRIVER_MEMORY_MIB=N    so does memory that would bring what is allocated to this and more
// FAULTY_DRIVER_BUDGET_MIB=N    tells by VK_EXT_memory_budget that so much is granted, and how much is allocated
//
// The declarations are those of the Vulkan loader's layer interface, version 2 (LoaderLayerInterface.md), so that no
// header has to be installed.

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OUT_OF_DEVICE_MEMORY = -2, INITIALIZATION_FAILED = -3, DEVICE_LOST = -4 };
enum { INCOMPLETE = 5, MEMORY_BUDGET_PROPERTIES = 1000237000, HEAPS = 16 };
enum { LOADER_INSTANCE_CREATE_INFO = 47, LOADER_DEVICE_CREATE_INFO = 48, LINK_INFO = 0, MOST_ALLOCATIONS = 65536 };

typedef void (*Function)(void);
typedef Function (*GetProcAddr)(void *handle, const char *name);
typedef uint64_t Memory;

typedef struct Link {
    struct Link *next;
    GetProcAddr next_instance, next_device;
} Link;
typedef struct CreateInfo {
    uint32_t type;
    const struct CreateInfo *next;
    uint32_t function;
    Link *link;
} CreateInfo;
typedef struct {
    uint32_t type;
    const void *next;
    uint64_t size;
    uint32_t kind;
} AllocateInfo;
typedef struct {
    uint32_t type;
    void *next;
    uint32_t version;
    GetProcAddr instance, device, physical_device;
} NegotiateInterface;

typedef struct {
    char name[256];
    uint32_t version;
} Extension;
typedef struct Properties {
    uint32_t type;
    struct Properties *next;
    uint64_t budget[HEAPS], usage[HEAPS];
} Properties;

typedef int (*CreateBuffer)(void *, const void *, const void *, uint64_t *);
typedef int (*EnumerateExtensions)(void *, const char *, uint32_t *, Extension *);
typedef void (*GetMemoryProperties)(void *, Properties *);
typedef int (*CreateInstance)(const CreateInfo *, const void *, void **);
typedef int (*CreateDevice)(void *, const CreateInfo *, const void *, void **);
typedef int (*QueueSubmit)(void *, uint32_t, const void *, uint64_t);
typedef int (*AllocateMemory)(void *, const AllocateInfo *, const void *, Memory *);
typedef void (*FreeMemory)(void *, Memory, const void *);

static GetProcAddr next_instance, next_device;
static QueueSubmit next_submit;
static AllocateMemory next_allocate;
static FreeMemory next_free;
static CreateBuffer next_buffer;
static EnumerateExtensions next_extensions;
static GetMemoryProperties next_properties;
static struct { Memory memory; uint64_t size; } allocations[MOST_ALLOCATIONS];
static uint64_t submissions, allocated;

static uint64_t setting(const char *name) {
    const char *text = getenv(name);
    return text ? strtoull(text, NULL, 10) : UINT64_MAX;
}

static void note(char what) {
    const char *place = getenv("FAULTY_DRIVER_NOTES");
    FILE *file = place ? fopen(place, "a") : NULL;
    if (!file) return;
    fputc(what, file);
    fclose(file);
}

static int submit(void *queue, uint32_t count, const void *infos, uint64_t fence) {
    submissions += 1;
    note('.');
    return submissions >= setting("FAULTY_DRIVER_LOST_AT") ? DEVICE_LOST : next_submit(queue, count, infos, fence);
}

static int refuse(void) {
    note('!');
    return OUT_OF_DEVICE_MEMORY;
}

static int create_buffer(void *device, const void *info, const void *allocator, uint64_t *buffer) {
    if (submissions >= setting("FAULTY_DRIVER_FULL_AT")) return refuse();
    return next_buffer(device, info, allocator, buffer);
}

static int allocate(void *device, const AllocateInfo *info, const void *allocator, Memory *memory) {
    if ((allocated + info->size) >> 20 >= setting("FAULTY_DRIVER_MEMORY_MIB")) return refuse();
    int result = next_allocate(device, info, allocator, memory);
    for (size_t i = 0; result == 0 && i < MOST_ALLOCATIONS; i++) {
        if (allocations[i].memory) continue;
        allocations[i].memory = *memory;
        allocations[i].size = info->size;
        allocated += info->size;
        break;
    }
    return result;
}

static void release(void *device, Memory memory, const void *allocator) {
    for (size_t i = 0; memory && i < MOST_ALLOCATIONS; i++) {
        if (allocations[i].memory != memory) continue;
        allocated -= allocations[i].size;
        allocations[i].memory = 0;
        break;
    }
    next_free(device, memory, allocator);
}

// The extensions of the driver and one more.
static int extensions(void *physical, const char *layer, uint32_t *count, Extension *list) {
    if (getenv("FAULTY_DRIVER_BUDGET_MIB") == NULL) return next_extensions(physical, layer, count, list);
    const Extension budget = { "VK_EXT_memory_budget", 1 };
    uint32_t room = *count;
    if (list && room == 0) return INCOMPLETE;
    if (list) *count = room - 1;
    int result = next_extensions(physical, layer, count, list);
    if (list) list[*count] = budget;
    *count += 1;
    return result;
}

static void memory_properties(void *physical, Properties *properties) {
    next_properties(physical, properties);
    uint64_t budget = setting("FAULTY_DRIVER_BUDGET_MIB");
    for (Properties *at = properties; budget != UINT64_MAX && at; at = at->next) {
        if (at->type != MEMORY_BUDGET_PROPERTIES) continue;
        for (int heap = 0; heap < HEAPS; heap++) {
            at->budget[heap] = budget << 20;
            at->usage[heap] = allocated;
        }
    }
}

// The link of this layer in the chain, moved on to that of the next.
static const Link *take_link(const CreateInfo *info, uint32_t type) {
    const CreateInfo *at = info->next;
    while (at && !(at->type == type && at->function == LINK_INFO)) at = at->next;
    if (!at) return NULL;
    const Link *link = at->link;
    ((CreateInfo *)at)->link = link->next;
    return link;
}

static int create_instance(const CreateInfo *info, const void *allocator, void **instance) {
    const Link *link = take_link(info, LOADER_INSTANCE_CREATE_INFO);
    if (!link) return INITIALIZATION_FAILED;
    next_instance = link->next_instance;
    int result = ((CreateInstance)next_instance(NULL, "vkCreateInstance"))(info, allocator, instance);
    if (result == 0) {
        next_extensions = (EnumerateExtensions)next_instance(*instance, "vkEnumerateDeviceExtensionProperties");
        next_properties = (GetMemoryProperties)next_instance(*instance, "vkGetPhysicalDeviceMemoryProperties2");
    }
    return result;
}

static int create_device(void *physical, const CreateInfo *info, const void *allocator, void **device) {
    const Link *link = take_link(info, LOADER_DEVICE_CREATE_INFO);
    if (!link) return INITIALIZATION_FAILED;
    next_device = link->next_device;
    CreateDevice create = (CreateDevice)link->next_instance(NULL, "vkCreateDevice");
    int result = create(physical, info, allocator, device);
    if (result == 0) {
        next_submit = (QueueSubmit)next_device(*device, "vkQueueSubmit");
        next_allocate = (AllocateMemory)next_device(*device, "vkAllocateMemory");
        next_free = (FreeMemory)next_device(*device, "vkFreeMemory");
        next_buffer = (CreateBuffer)next_device(*device, "vkCreateBuffer");
    }
    return result;
}

static Function device_function(void *device, const char *name) {
    if (!strcmp(name, "vkGetDeviceProcAddr")) return (Function)device_function;
    if (!strcmp(name, "vkQueueSubmit")) return (Function)submit;
    if (!strcmp(name, "vkAllocateMemory")) return (Function)allocate;
    if (!strcmp(name, "vkFreeMemory")) return (Function)release;
    if (!strcmp(name, "vkCreateBuffer")) return (Function)create_buffer;
    return device ? next_device(device, name) : NULL;
}

static Function instance_function(void *instance, const char *name) {
    if (!strcmp(name, "vkGetInstanceProcAddr")) return (Function)instance_function;
    if (!strcmp(name, "vkCreateInstance")) return (Function)create_instance;
    if (!strcmp(name, "vkCreateDevice")) return (Function)create_device;
    if (!strcmp(name, "vkEnumerateDeviceExtensionProperties")) return (Function)extensions;
    // With and without the ending KHR.
    if (!strncmp(name, "vkGetPhysicalDeviceMemoryProperties2", 36)) return (Function)memory_properties;
    Function own = device_function(NULL, name);
    return own ? own : instance ? next_instance(instance, name) : NULL;
}

int vkNegotiateLoaderLayerInterfaceVersion(NegotiateInterface *interface) {
    if (interface->version > 2) interface->version = 2;
    interface->instance = instance_function;
    interface->device = device_function;
    interface->physical_device = NULL;
    return 0;
}
