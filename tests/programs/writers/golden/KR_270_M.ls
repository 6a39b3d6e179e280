/PROG  KR_270_M
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 107;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 4 ;
   2:  !experiments in 3 configurations. ;
   3:  !Made by elastocal 0.1.0 from 'KR ;
   4:  !270 milling cell', plan sha256 ;
   5:  !0123456789abcdef. ;
   6:  !Robot: kuka-kr270. Joint values: ;
   7:  !deg, mm, as in the model. ;
   8:  !Forces act at the load point of ;
   9:  !the tool, in the axes of the ;
  10:  !robot base. ;
  11:  !No home position: the first ;
  12:  !motion starts where the robot ;
  13:  !stands. ;
  14:  !SAFETY: check this program at ;
  15:  !low speed in manual mode first. ;
  16:  !Motions between the points are ;
  17:  !not checked for collisions by ;
  18:  !this file. ;
  19:  !Set the payload of the empty ;
  20:  !calibration tool and leave it ;
  21:  !so, loaded and unloaded: the ;
  22:  !controller must not compensate ;
  23:  !what is to be measured. ;
  24:  UFRAME_NUM=0 ;
  25:  UTOOL_NUM=1 ;
  26:  !to AP1 ;
  27:J P[1] 10% FINE    ;
  28:  !to P1 ;
  29:J P[2] 10% FINE    ;
  30:  WAIT   2.00(sec) ;
  31:  MESSAGE[Experiment 1/4: pose 1.] ;
  32:  MESSAGE[NO load. Measure M1.] ;
  33:  PAUSE ;
  34:  MESSAGE[Experiment 1/4: hang] ;
  35:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  36:  MESSAGE[-2500 N.] ;
  37:  PAUSE ;
  38:  WAIT   2.00(sec) ;
  39:  MESSAGE[Experiment 1/4: pose 1.] ;
  40:  MESSAGE[LOADED. Measure M1.] ;
  41:  PAUSE ;
  42:  MESSAGE[Experiment 1/4: take the] ;
  43:  MESSAGE[load off. The robot] ;
  44:  MESSAGE[moves next.] ;
  45:  PAUSE ;
  46:  !to AP1 ;
  47:J P[1] 10% FINE    ;
  48:  !to P1 ;
  49:J P[2] 10% FINE    ;
  50:  WAIT   2.00(sec) ;
  51:  MESSAGE[Experiment 2/4: pose 1.] ;
  52:  MESSAGE[NO load. Measure M1.] ;
  53:  PAUSE ;
  54:  MESSAGE[Experiment 2/4: hang] ;
  55:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  56:  MESSAGE[-2500 N.] ;
  57:  PAUSE ;
  58:  WAIT   2.00(sec) ;
  59:  MESSAGE[Experiment 2/4: pose 1.] ;
  60:  MESSAGE[LOADED. Measure M1.] ;
  61:  PAUSE ;
  62:  MESSAGE[Experiment 2/4: take the] ;
  63:  MESSAGE[load off. The robot] ;
  64:  MESSAGE[moves next.] ;
  65:  PAUSE ;
  66:  !to AP2 ;
  67:J P[3] 10% FINE    ;
  68:  !to P2 ;
  69:J P[4] 10% FINE    ;
  70:  WAIT   2.00(sec) ;
  71:  MESSAGE[Experiment 3/4: pose 2.] ;
  72:  MESSAGE[NO load. Measure M1.] ;
  73:  PAUSE ;
  74:  MESSAGE[Experiment 3/4: hang] ;
  75:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  76:  MESSAGE[-2500 N.] ;
  77:  PAUSE ;
  78:  WAIT   2.00(sec) ;
  79:  MESSAGE[Experiment 3/4: pose 2.] ;
  80:  MESSAGE[LOADED. Measure M1.] ;
  81:  PAUSE ;
  82:  MESSAGE[Experiment 3/4: take the] ;
  83:  MESSAGE[load off. The robot] ;
  84:  MESSAGE[moves next.] ;
  85:  PAUSE ;
  86:  !to AP3 ;
  87:J P[5] 10% FINE    ;
  88:  !to P3 ;
  89:J P[6] 10% FINE    ;
  90:  WAIT   2.00(sec) ;
  91:  MESSAGE[Experiment 4/4: pose 3.] ;
  92:  MESSAGE[NO load. Measure M1.] ;
  93:  PAUSE ;
  94:  MESSAGE[Experiment 4/4: hang] ;
  95:  MESSAGE[254.929 kg, Fx 0 Fy 0 Fz] ;
  96:  MESSAGE[-2500 N.] ;
  97:  PAUSE ;
  98:  WAIT   2.00(sec) ;
  99:  MESSAGE[Experiment 4/4: pose 3.] ;
 100:  MESSAGE[LOADED. Measure M1.] ;
 101:  PAUSE ;
 102:  MESSAGE[Experiment 4/4: take the] ;
 103:  MESSAGE[load off. The robot] ;
 104:  MESSAGE[moves next.] ;
 105:  PAUSE ;
 106:  !to AP3 ;
 107:J P[5] 10% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -51.2922 deg,	J3=   62.5588 deg,
	J4=  -32.0611 deg,	J5=  101.1598 deg,	J6=  -94.2903 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -50.7922 deg,	J3=   63.0588 deg,
	J4=  -32.5611 deg,	J5=  101.6598 deg,	J6=  -93.7903 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=  -55.9571 deg,	J3=  -72.9034 deg,
	J4= -118.8938 deg,	J5=  -57.0916 deg,	J6= -179.7668 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=  -55.4571 deg,	J3=  -72.4034 deg,
	J4= -119.3938 deg,	J5=  -56.5916 deg,	J6= -179.2668 deg
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   -0.5000 deg,	J2=   -2.1852 deg,	J3=   -4.2994 deg,
	J4=  -57.7496 deg,	J5=   39.0358 deg,	J6=  168.3163 deg
};
P[6]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=   -1.6852 deg,	J3=   -3.7994 deg,
	J4=  -58.2496 deg,	J5=   39.5358 deg,	J6=  168.8163 deg
};
/END
