// The views of captures on this device.
() =>
  new Promise((done) => {
    const opening = indexedDB.open("calibdb", 1);
    opening.onsuccess = () => {
      const asking = opening.result.transaction("captures").objectStore("captures").getAll();
      asking.onsuccess = () => done(asking.result.flatMap(({ views }) => views));
    };
  });
