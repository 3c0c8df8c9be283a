"""The main window, its menus, toolbars and workspaces."""
