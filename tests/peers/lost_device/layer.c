/* A Vulkan layer between a program and its driver that loses the device, as a driver does that was reset or removed: from then on every submission, wait,
 * acquisition and presentation of that device answers VK_ERROR_DEVICE_LOST. Devices that are opened later work, unless they are to be refused.
 *
 * The folder that LOSE_DEVICE names is what it obeys: a file "lose" loses the devices that are open (it is removed once that is done), and as long as there is a
 * file "refuse" no device opens. The program knows nothing of it: `VK_LAYER_PATH` and `VK_INSTANCE_LAYERS` put the layer there.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#define DEVICES 64

static PFN_vkGetInstanceProcAddr next_instance_proc;
static struct {
    VkDevice device;
    void *key;
    PFN_vkGetDeviceProcAddr proc;
    int lost;
} devices[DEVICES];

/* The loader's table of a device, which its queues share. */
static void *key_of(void *handle) { return *(void **)handle; }

static int index_of(void *handle) {
    for (int k = 0; k < DEVICES; k++)
        if (devices[k].device && devices[k].key == key_of(handle)) return k;
    fprintf(stderr, "lose-device: a device that was not opened here\n");
    abort();
}

static int there_is(const char *name, int removed) {
    const char *folder = getenv("LOSE_DEVICE");
    char path[4096];
    if (!folder) return 0;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    if (access(path, F_OK)) return 0;
    if (removed) unlink(path);
    return 1;
}

/* Whether the device of this handle is lost by now. */
static int is_lost(void *handle) {
    if (there_is("lose", 1))
        for (int k = 0; k < DEVICES; k++)
            if (devices[k].device) {
                /* A lost device does nothing any more; the driver below is alive and would read what is freed from now on. */
                ((PFN_vkDeviceWaitIdle)devices[k].proc(devices[k].device, "vkDeviceWaitIdle"))(devices[k].device);
                devices[k].lost = 1;
            }
    return devices[index_of(handle)].lost;
}

#define NEXT(handle, name) ((PFN_##name)devices[index_of(handle)].proc(devices[index_of(handle)].device, #name))

static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t n, const VkSubmitInfo *infos, VkFence fence) {
    return is_lost(queue) ? VK_ERROR_DEVICE_LOST : NEXT(queue, vkQueueSubmit)(queue, n, infos, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL present(VkQueue queue, const VkPresentInfoKHR *info) {
    return is_lost(queue) ? VK_ERROR_DEVICE_LOST : NEXT(queue, vkQueuePresentKHR)(queue, info);
}

static VKAPI_ATTR VkResult VKAPI_CALL acquire(VkDevice device, VkSwapchainKHR chain, uint64_t timeout, VkSemaphore semaphore, VkFence fence, uint32_t *index) {
    return is_lost(device) ? VK_ERROR_DEVICE_LOST : NEXT(device, vkAcquireNextImageKHR)(device, chain, timeout, semaphore, fence, index);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_fences(VkDevice device, uint32_t n, const VkFence *fences, VkBool32 all, uint64_t timeout) {
    return is_lost(device) ? VK_ERROR_DEVICE_LOST : NEXT(device, vkWaitForFences)(device, n, fences, all, timeout);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_semaphores(VkDevice device, const VkSemaphoreWaitInfo *info, uint64_t timeout) {
    return is_lost(device) ? VK_ERROR_DEVICE_LOST : NEXT(device, vkWaitSemaphores)(device, info, timeout);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_semaphores_khr(VkDevice device, const VkSemaphoreWaitInfo *info, uint64_t timeout) {
    return is_lost(device) ? VK_ERROR_DEVICE_LOST : NEXT(device, vkWaitSemaphoresKHR)(device, info, timeout);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_idle(VkDevice device) {
    return is_lost(device) ? VK_ERROR_DEVICE_LOST : NEXT(device, vkDeviceWaitIdle)(device);
}

static VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice device, const VkAllocationCallbacks *allocator) {
    if (!device) return;
    int k = index_of(device);
    PFN_vkDestroyDevice next = NEXT(device, vkDestroyDevice);
    devices[k].device = NULL;
    next(device, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info, const VkAllocationCallbacks *allocator, VkInstance *instance) {
    VkLayerInstanceCreateInfo *link = (VkLayerInstanceCreateInfo *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (VkLayerInstanceCreateInfo *)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    return ((PFN_vkCreateInstance)next_instance_proc(NULL, "vkCreateInstance"))(info, allocator, instance);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info, const VkAllocationCallbacks *allocator, VkDevice *device) {
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (VkLayerDeviceCreateInfo *)link->pNext;
    if (!link || there_is("refuse", 0)) return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    PFN_vkGetDeviceProcAddr device_proc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    VkResult result = ((PFN_vkCreateDevice)instance_proc(NULL, "vkCreateDevice"))(physical, info, allocator, device);
    if (result) return result;
    for (int k = 0; k < DEVICES; k++)
        if (!devices[k].device) {
            devices[k].device = *device;
            devices[k].key = key_of(*device);
            devices[k].proc = device_proc;
            devices[k].lost = 0;
            return VK_SUCCESS;
        }
    fprintf(stderr, "lose-device: more than %d devices\n", DEVICES);
    abort();
}

static PFN_vkVoidFunction own(const char *name);

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_proc(VkDevice device, const char *name) {
    PFN_vkVoidFunction found = own(name);
    PFN_vkVoidFunction next = devices[index_of(device)].proc(device, name);
    /* What the driver lacks the layer does not have, either. */
    return found && next ? found : next;
}

__attribute__((visibility("default"))) VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance, const char *name) {
    PFN_vkVoidFunction found = own(name);
    if (found) return found;
    return instance && next_instance_proc ? next_instance_proc(instance, name) : NULL;
}

__attribute__((visibility("default"))) VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetDeviceProcAddr(VkDevice device, const char *name) {
    return device_proc(device, name);
}

static PFN_vkVoidFunction own(const char *name) {
#define OWN(vulkan, function) \
    if (!strcmp(name, #vulkan)) return (PFN_vkVoidFunction)function
    OWN(vkGetInstanceProcAddr, vkGetInstanceProcAddr);
    OWN(vkGetDeviceProcAddr, vkGetDeviceProcAddr);
    OWN(vkCreateInstance, create_instance);
    OWN(vkCreateDevice, create_device);
    OWN(vkDestroyDevice, destroy_device);
    OWN(vkQueueSubmit, submit);
    OWN(vkQueuePresentKHR, present);
    OWN(vkAcquireNextImageKHR, acquire);
    OWN(vkWaitForFences, wait_fences);
    OWN(vkWaitSemaphores, wait_semaphores);
    OWN(vkWaitSemaphoresKHR, wait_semaphores_khr);
    OWN(vkDeviceWaitIdle, wait_idle);
    return NULL;
}
