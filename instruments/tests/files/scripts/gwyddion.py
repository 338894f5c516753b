"""Gwyddion without its windows: loads files and saves them in other formats, through its shared libraries."""

import ctypes as c
import glob
import os

NONINTERACTIVE = 1 << 1
SAVE = 1 << 2


def _library(name):
    return c.CDLL(name, mode=c.RTLD_GLOBAL)


_glib, _object = _library("libglib-2.0.so.0"), _library("libgobject-2.0.so.0")
_gtk = _library("libgtk-x11-2.0.so.0")
_parts = {n: _library(f"libgwy{n}.so.0") for n in ["ddion2", "process2", "draw2", "dgets2", "module2", "app2"]}
_files, _app = _parts["module2"], _parts["app2"]
_has_display = _gtk.gtk_init_check(None, None)
_parts["dgets2"].gwy_widgets_type_init()
_folder = glob.glob("/usr/lib/*/gwyddion/modules/file")[0].encode()
_files.gwy_module_register_modules((c.c_char_p * 2)(_folder, None))
_app.gwy_app_data_browser_set_gui_enabled(0)


class _Error(c.Structure):
    _fields_ = [("domain", c.c_uint32), ("code", c.c_int), ("message", c.c_char_p)]


_Tick = c.CFUNCTYPE(c.c_int, c.c_void_p)
_ACCEPT = -5


@_Tick
def _accept_dialogs(_):
    """Presses OK in every dialog, as some exports always ask."""
    windows = _gtk.gtk_window_list_toplevels()
    for k in range(_glib.g_list_length(c.c_void_p(windows))):
        window = c.c_void_p(_glib.g_list_nth_data(c.c_void_p(windows), k))
        if _object.g_type_check_instance_is_a(window, c.c_size_t(_gtk.gtk_dialog_get_type())):
            _gtk.gtk_dialog_response(window, _ACCEPT)
    return 1


for _function in [_gtk.gtk_window_list_toplevels, _glib.g_list_nth_data, _app.gwy_app_settings_get]:
    _function.restype = c.c_void_p
_gtk.gtk_dialog_get_type.restype = c.c_size_t
_glib.g_timeout_add(300, _accept_dialogs, None)


def setting(name, value):
    """Sets a switch that a dialog remembers."""
    settings = c.c_void_p(_app.gwy_app_settings_get())
    key = _glib.g_quark_from_string(name.encode())
    _parts["ddion2"].gwy_container_set_boolean(settings, key, int(value))


def load(path):
    """Opens a file and makes its first channel the current one."""
    error = c.POINTER(_Error)()
    _files.gwy_file_load.restype = c.c_void_p
    data = _files.gwy_file_load(os.fsencode(path), NONINTERACTIVE, c.byref(error))
    if not data:
        raise OSError(f"{path}: {error.contents.message.decode() if error else 'not loaded'}")
    _app.gwy_app_data_browser_add(c.c_void_p(data))
    _app.gwy_app_data_browser_select_data_field(c.c_void_p(data), 0)
    return data


def save(data, path, function):
    """Saves the current channel with one of Gwyddion's file functions."""
    error = c.POINTER(_Error)()
    operations = _files.gwy_file_func_get_operations(function.encode())
    run = _files.gwy_file_func_run_save if operations & SAVE else _files.gwy_file_func_run_export
    done = run(function.encode(), c.c_void_p(data), os.fsencode(path), NONINTERACTIVE, c.byref(error))
    if not done:
        raise OSError(f"{path}: {error.contents.message.decode() if error else 'not saved'}")
